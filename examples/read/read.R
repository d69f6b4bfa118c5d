# Median step time of every cell of a results file: Rscript read.R OUT.h5
library(ncdf4)
file <- nc_open(commandArgs(trailingOnly = TRUE)[1])
axes <- strsplit(ncatt_get(file, 0, "axes")$value, " ")[[1]]
step <- match("step", ncvar_get(file, "phase"))

# Facts of the runs are called "run/host", errors "accuracy/energy", their axes "accuracy/hz".
# R sees the dimensions reversed: cycle, phase, rep, and the axes, the last one first.
duration <- ncvar_get(file, "duration", collapse_degen = FALSE)
extent <- dim(duration)
dim(duration) <- c(extent[1], extent[2], extent[3], prod(extent[-(1:3)]))
cells <- expand.grid(lapply(setNames(nm = rev(axes)), function(a) as.vector(ncvar_get(file, a))))
cells$ns <- apply(duration[, step, , , drop = FALSE], 4, median, na.rm = TRUE)
write.table(format(cells[!is.na(cells$ns), c(axes, "ns")], digits = 15, trim = TRUE),
            sep = "\t", quote = FALSE, row.names = FALSE, col.names = FALSE)
