# Selects values by label in each group of a results file: Rscript labels.R hdf5r|ncdf4 FOLDER
arguments <- commandArgs(trailingOnly = TRUE)
reader <- arguments[1]
folder <- arguments[2]
path <- file.path(folder, "out.h5")
if (reader == "hdf5r") {
  results <- hdf5r::H5File$new(path, "r")
  read <- function(name) results[[name]]$read()
} else {
  results <- ncdf4::nc_open(path)
  read <- function(name) ncdf4::ncvar_get(results, name, collapse_degen = FALSE)
}
read_once <- local({
  known <- list()
  function(name) {
    if (is.null(known[[name]])) known[[name]] <<- read(name)
    known[[name]]
  }
})
found <- 0
lines <- readLines(file.path(folder, "labels.tsv"), encoding = "UTF-8")
for (fields in strsplit(lines, "\t", fixed = TRUE)) {
  name <- fields[1]
  group <- sub("[^/]*$", "", name)
  labels <- strsplit(fields[2:(length(fields) - 1)], "=", fixed = TRUE)
  at <- vapply(labels, function(label) {
    coordinate <- as.vector(read_once(paste0(group, label[1])))
    match(if (is.numeric(coordinate)) as.numeric(label[2]) else label[2], coordinate)
  }, 1L)
  # R sees the dimensions reversed.
  value <- do.call(`[`, c(list(read_once(name)), as.list(rev(at))))
  wanted <- fields[length(fields)]
  if (is.character(value)) Encoding(value) <- "UTF-8"
  same <- if (is.character(value)) value == wanted else value == as.numeric(wanted)
  if (!isTRUE(same)) stop(paste(fields, collapse = " "), ": found ", value)
  found <- found + 1
}
stopifnot(found > 50)
cat(reader, "found", found, "values by label\n")
