# Holds a results file against what is known of it: Rscript check.R hdf5r|ncdf4 FOLDER
arguments <- commandArgs(trailingOnly = TRUE)
reader <- arguments[1]
folder <- arguments[2]
path <- file.path(folder, "out.h5")
if (reader == "hdf5r") {
  results <- hdf5r::H5File$new(path, "r")
  read <- function(name) results[[name]]$read()
  stopifnot(hdf5r::h5attr(results, "axes") == "quantity size detector")
} else {
  results <- ncdf4::nc_open(path)
  read <- function(name) ncdf4::ncvar_get(results, name, collapse_degen = FALSE)
  stopifnot(ncdf4::ncatt_get(results, 0, "axes")$value == "quantity size detector")
}
arrays <- 0
for (kind in c("numbers", "texts")) {
  lines <- readLines(file.path(folder, paste0(kind, ".tsv")), encoding = "UTF-8")
  for (fields in strsplit(paste0(lines, "\t."), "\t", fixed = TRUE)) {
    wanted <- head(fields[-(1:2)], -1)
    found <- read(fields[1])
    shape <- rev(as.integer(strsplit(fields[2], " ")[[1]]))  # R sees the dimensions reversed
    if (!identical(as.integer(if (is.null(dim(found))) length(found) else dim(found)), shape))
      stop(fields[1], " has another shape")
    if (kind == "numbers") {
      wanted <- as.numeric(wanted)
      found <- as.numeric(found)
      # A reader may show the fill value -1 of integers as no value.
      same <- ifelse(is.na(found), is.na(wanted) | wanted == -1, !is.na(wanted) & found == wanted)
    } else {
      found <- as.character(found)
      Encoding(found) <- "UTF-8"
      same <- found == wanted
    }
    if (!all(same)) stop(fields[1], " differs at ", paste(which(!same), collapse = " "))
    arrays <- arrays + 1
  }
}
stopifnot(arrays >= 54)
cat(reader, "read", arrays, "arrays\n")
