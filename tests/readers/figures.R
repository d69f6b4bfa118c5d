# What figures.R draws against the numbers of the file: Rscript figures.R CDB ACCURACY.cdb FOLDER
arguments <- commandArgs(trailingOnly = TRUE)
program <- arguments[1]; scenario <- arguments[2]; folder <- arguments[3]
source(file.path(dirname(scenario), "read", "figures.R"))
checked <- 0
check <- function(found, wanted) {
  found <- as.numeric(found); wanted <- as.numeric(wanted)
  stopifnot(length(found) == length(wanted), length(found) > 0)
  stopifnot(is.na(found) == is.na(wanted), abs(found - wanted) <= 6e-6 * abs(wanted) | is.na(wanted))
  checked <<- checked + length(found)
}

fixture <- file.path(folder, "out.h5")
f <- cdb_figures(fixture, cdb = program)
png(file.path(folder, "figure_r%d.png"), 512, 368)
nc <- ncdf4::nc_open(fixture)
duration <- ncdf4::ncvar_get(nc, "duration", collapse_degen = FALSE)  # cycle phase rep detector size quantity
names <- as.vector(ncdf4::ncvar_get(nc, "phase"))
ncdf4::nc_close(nc)

drawn <- cdb_phases(fixture, quantity = 30, size = 1.25, detector = "dbvt")
for (phase in colnames(drawn))
  check(drawn[, phase], apply(duration[, match(phase, names), , 2, 2, 3], 1, median))

drawn <- cdb_over(f, "quantity", size = 1.25, detector = NULL)
whole <- which(f$points$repeats[cdb_at(f, c("quantity", "detector"), list(size = 1.25))] == 2)
check(drawn$us[whole] * 1000, vapply(whole, function(i) {
  q <- match(drawn$x[i], c(10, 20, 30)); d <- match(drawn$line[i], c("simple", "dbvt"))
  mean(apply(duration[, match("step", names), , d, 2, q], 1, median))
}, 1))

drawn <- cdb_ratios(f)
check(drawn$value, f$ratios$means$step$value)
drawn <- cdb_stability(f, "quantity", "detector")
stopifnot(drawn$verdict == f$points$verdict[f$places$size == 0.5])

result <- file.path(folder, "accuracy_r.h5")
stopifnot(system2(program, c("run", "-q", "--fresh", "-b", "accuracy", "-o", result, scenario), stdout = FALSE) == 0)
f <- cdb_figures(result, cdb = program)
drawn <- cdb_errors(f, "position")
nc <- ncdf4::nc_open(result)
errors <- ncdf4::ncvar_get(nc, "accuracy/position")  # iterations hz
ncdf4::nc_close(nc)
check(drawn$error, mapply(function(hz, n) errors[match(n, c(5, 20)), match(hz, c(60, 120, 240))], drawn$at$hz, drawn$at$iterations))
invisible(dev.off())
cat("checked", checked, "numbers of figures\n")
