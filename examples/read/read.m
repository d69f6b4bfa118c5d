% Median step time of every cell of a results file: octave-cli read.m OUT.h5
pkg load netcdf
file = argv(){end};
axes = strsplit(ncreadatt(file, "/", "axes"), " ");
function names = coordinate(file, axis)  % text coordinates have their values in `labels`
  try
    names = strsplit(ncreadatt(file, axis, "labels"), ncreadatt(file, axis, "labels_separator"));
  catch
    names = arrayfun(@(x) sprintf("%.15g", x), ncread(file, axis), "UniformOutput", false);
  end
end
values = cellfun(@(axis) coordinate(file, axis), axes, "UniformOutput", false);
step = find(strcmp(coordinate(file, "phase"), "step"));

% Numbers in groups are called "/run/peak_rss", "/accuracy/energy", their axes "/accuracy/hz".
% Octave sees the dimensions reversed: cycle, phase, rep, and the axes, the last one first.
duration = ncread(file, "duration");
cells = reshape(duration(:, step, :), size(duration, 1) * size(duration, 3), []);
at = cell(1, numel(axes));
for i = 1:columns(cells)
  ns = cells(!isnan(cells(:, i)), i);
  if isempty(ns), continue; end
  [at{:}] = ind2sub([fliplr(cellfun(@numel, values)) 1], i);
  printf("%s\t", cellfun(@(v, k) v{k}, values, fliplr(at), "UniformOutput", false){:});
  printf("%.15g\n", median(ns));
end
