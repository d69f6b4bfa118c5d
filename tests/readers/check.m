% Holds a results file against what is known of it: octave-cli check.m FOLDER
pkg load netcdf
folder = argv(){end};
file = [folder "/out.h5"];
assert(ncreadatt(file, "/", "axes"), "quantity size detector");
arrays = 0;
lines = strsplit(strtrim(fileread([folder "/numbers.tsv"])), "\n");
for i = 1:numel(lines)
  fields = strsplit(lines{i}, "\t");
  shape = fliplr(str2num(fields{2}));  % Octave sees the dimensions reversed
  wanted = str2double(fields(3:end))(:);
  name = fields{1};
  if any(name == "/"), name = ["/" name]; end  % a variable of a group
  found = ncread(file, name);
  assert(size(found)(1:numel(shape)), shape);
  found = double(found(:));
  % Octave shows the fill value of integers as no value.
  same = found == wanted | (isnan(found) & (isnan(wanted) | wanted == -1));
  assert(all(same), fields{1});
  ++arrays;
end
lines = strsplit(strtrim(fileread([folder "/texts.tsv"])), "\n");
for i = 1:numel(lines)
  fields = strsplit(lines{i}, "\t");
  if any(strcmp(fields{1}, {"detector", "phase", "pose"}))
    separator = ncreadatt(file, fields{1}, "labels_separator");
    assert(strsplit(ncreadatt(file, fields{1}, "labels"), separator), fields(3:end));
    ++arrays;
  end
end
assert(arrays >= 45);
printf("Octave read %d arrays\n", arrays);
