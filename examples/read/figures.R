# The figures of a results file, in base graphics. All statistics are those of cdb:
#   source("figures.R")
#   f <- cdb_figures("first.h5")             # cdb show --json; cdb is in PATH or in $CDB
#   f$conclusions; f$warnings$text           # what the sweep answers, and what to know first
#   cdb_phases("first.h5", detector = "dbvt")   # phases over the cycles, from the file itself
#   cdb_over(f, "quantity"); cdb_ratios(f); cdb_errors(f, "position"); cdb_stability(f, "quantity", "detector")
# Each draws one figure and returns, invisibly, what it drew.  Rscript figures.R OUT.h5 OUT.pdf draws all.
library(jsonlite)

cdb_colours <- c("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")

cdb_figures <- function(file, cdb = Sys.getenv("CDB", "cdb"), select = character()) {
  options <- unlist(lapply(select, function(part) c("--select", shQuote(part))))
  out <- suppressWarnings(system2(cdb, c("show", shQuote(file), "--json", options), stdout = TRUE))
  # Status 3: some run failed, which the document says.
  if (length(out) == 0) stop("cdb show --json said nothing of ", file)
  figures <- fromJSON(paste(out, collapse = "\n"), simplifyMatrix = FALSE, simplifyDataFrame = TRUE)
  at <- lapply(figures$points$at, as.integer)
  names <- figures$axes$name
  # The place of each point, a column for each axis.
  figures$places <- setNames(as.data.frame(lapply(seq_along(names), function(i)
    figures$axes$values[[i]][vapply(at, function(place) place[i] + 1L, 1L)])), names)
  if (length(names) == 0) figures$places <- data.frame(row.names = seq_along(at))
  figures
}

# The points with these values; axes that are neither named nor `free` are at their first value.
cdb_at <- function(figures, free, place) {
  keep <- rep(TRUE, length(figures$points$at))
  for (axis in setdiff(figures$axes$name, free)) {
    values <- figures$axes$values[[match(axis, figures$axes$name)]]
    value <- if (is.null(place[[axis]])) values[1] else place[[axis]]
    if (!value %in% values) stop("the axis ", axis, " has no value ", value)
    keep <- keep & figures$places[[axis]] == value
  }
  which(keep)
}

cdb_foot <- function(text) mtext(paste(strwrap(text, 95), collapse = "\n"), 1, 5.2, adj = 0, cex = 0.6, col = "#555555")
cdb_words <- function(figures) paste(figures$statistic, figures$interval$text)

# Colour and symbol of each line; void points are hollow.
cdb_over <- function(figures, axis, phase = "step", ...) {
  if (!axis %in% figures$axes$name) stop("there is no axis ", axis)
  detector <- if (is.null(figures$detector_axis)) NULL else figures$axes$name[figures$detector_axis + 1]
  if (identical(detector, axis)) detector <- NULL
  rows <- cdb_at(figures, c(axis, detector), list(...))
  time <- figures$points$times[[phase]]
  column <- function(name) as.numeric(time[[name]])[rows] / 1000
  drawn <- data.frame(x = figures$places[[axis]][rows], us = column("mean"), low = column("low"), high = column("high"),
                      line = if (is.null(detector)) phase else figures$places[[detector]][rows],
                      void = figures$points$is_void[rows])
  lines <- unique(drawn$line)
  par(mar = c(7, 4.5, 2.5, 1))
  plot(drawn$x, drawn$us, log = "xy", type = "n", xlab = figures$axes$label[match(axis, figures$axes$name)],
       ylab = paste0("mean time of ", phase, ", us"), main = figures$title, cex.main = 0.9,
       ylim = range(drawn[c("us", "low", "high")], na.rm = TRUE))
  for (i in seq_along(lines)) {
    own <- drawn[drawn$line == lines[i], ]
    colour <- cdb_colours[(i - 1) %% 7 + 1]
    lines(own$x[!own$void], own$us[!own$void], col = colour)
    points(own$x, own$us, col = colour, pch = ifelse(own$void, 1, 19))
    has <- which(own$high > own$low)
    if (length(has)) arrows(own$x[has], own$low[has], y1 = own$high[has], angle = 90, code = 3, length = 0.04, col = colour)
  }
  legend("topleft", as.character(lines), col = cdb_colours, pch = 19, lty = 1, bty = "n", cex = 0.8)
  cdb_foot(cdb_words(figures))
  invisible(drawn)
}

cdb_ratios <- function(figures, phase = "step") {
  if (is.null(figures$ratios)) stop("no detectors are compared in this file")
  means <- figures$ratios$means[[phase]]
  y <- rev(seq_len(nrow(means)))
  par(mar = c(7, 6, 2.5, 1))
  values <- unlist(means[c("value", "low", "high")])
  plot(means$value, y, log = "x", xlim = range(as.numeric(values), na.rm = TRUE), yaxt = "n", ylab = "", pch = 19,
       col = cdb_colours, main = figures$title, cex.main = 0.9,
       xlab = paste0("time of ", phase, " over that of ", figures$ratios$baseline, " (less is faster)"))
  axis(2, y, means$detector, las = 1)
  abline(v = 1, lty = 3)
  has <- which(as.numeric(means$high) > as.numeric(means$low))
  if (length(has)) arrows(means$low[has], y[has], means$high[has], angle = 90, code = 3, length = 0.04, col = cdb_colours[has])
  cdb_foot(paste0("Geometric mean over ", figures$ratios$matched, " of ", figures$ratios$cells, " cells. ", cdb_words(figures)))
  invisible(means)
}

# The most useful configurations are at the lower right.
cdb_errors <- function(figures, error, scene = 1) {
  fronts <- figures$fronts[figures$fronts$error == error, ]
  if (NROW(fronts) == 0) stop("there is no error ", error, " in this file")
  rows <- fronts$rows[[scene]]
  rows$speed <- 1000 / rows$ms_per_s
  rows <- rows[!is.na(rows$speed) & rows$error > 0, ]
  par(mar = c(7, 4.5, 2.5, 1))
  colour <- ifelse(rows$on_front, cdb_colours[1], "#999999")
  plot(rows$speed, rows$error, log = "xy", xlim = range(rows$speed) * c(0.5, 1.2), pch = ifelse(rows$is_void, 1, 19), col = colour, main = figures$title,
       cex.main = 0.9, xlab = "speed, times real time", ylab = error)
  has <- which(as.numeric(rows$high) > as.numeric(rows$low))
  if (length(has)) arrows(1000 / rows$high[has], rows$error[has], 1000 / rows$low[has], angle = 90, code = 3, length = 0.04, col = colour[has])
  has <- which(as.numeric(rows$error_high) > as.numeric(rows$error_low))
  if (length(has)) arrows(rows$speed[has], rows$error_low[has], y1 = rows$error_high[has], angle = 90, code = 3, length = 0.04, col = colour[has])
  text(rows$speed, rows$error, do.call(paste, c(rows$at, sep = ", ")), pos = 2, cex = 0.6, col = "#555555")
  front <- rows[rows$on_front, ]
  front <- front[order(front$speed), ]
  lines(front$speed, front$error, col = cdb_colours[1])
  mtext("better: fast and accurate", 1, -1.2, adj = 0.98, cex = 0.7, col = "#555555")
  cdb_foot(paste("Blue: on the front.", cdb_words(figures)))
  invisible(rows)
}

cdb_stability <- function(figures, x, y, ...) {
  rows <- cdb_at(figures, c(x, y), list(...))
  xs <- figures$axes$values[[match(x, figures$axes$name)]]
  ys <- figures$axes$values[[match(y, figures$axes$name)]]
  verdicts <- figures$points$verdict[rows]
  kinds <- unique(c("stable", verdicts))
  i <- match(figures$places[[x]][rows], xs)
  j <- match(figures$places[[y]][rows], ys)
  par(mar = c(6, 7, 2.5, 1))
  plot(NA, xlim = c(0.5, length(xs) + 0.5), ylim = c(0.5, length(ys) + 0.5), xaxt = "n", yaxt = "n", xlab = x, ylab = "",
       main = figures$title, cex.main = 0.9)
  fill <- c("#009E73", "#F0E442", "#E69F00", "#56B4E9", "#CC79A7", "#999999")
  rect(i - 0.48, j - 0.48, i + 0.48, j + 0.48, col = fill[(match(verdicts, kinds) - 1) %% 6 + 1], border = NA)
  cycle <- figures$points$first_bad_cycle[rows]
  text(i, j, ifelse(is.na(cycle), verdicts, paste0(verdicts, "\ncycle ", cycle)), cex = 0.7)
  axis(1, seq_along(xs), xs)
  axis(2, seq_along(ys), ys, las = 1)
  invisible(data.frame(x = xs[i], y = ys[j], verdict = verdicts))
}

# Medians over the repeats, from the file itself.
cdb_phases <- function(file, phases = c("broad", "narrow", "solve", "integrate", "step"), ...) {
  nc <- ncdf4::nc_open(file)
  on.exit(ncdf4::nc_close(nc))
  axes <- strsplit(ncdf4::ncatt_get(nc, 0, "axes")$value, " ")[[1]]
  duration <- ncdf4::ncvar_get(nc, "duration", collapse_degen = FALSE)  # cycle, phase, rep, the axes from the last
  place <- list(...)
  at <- vapply(rev(axes), function(axis) {
    values <- as.vector(ncdf4::ncvar_get(nc, axis))
    if (is.null(place[[axis]])) 1L else match(place[[axis]], values)
  }, 1L)
  extent <- dim(duration)
  cell <- if (length(at)) sum((at - 1) * cumprod(c(1, extent[-(1:3)]))[seq_along(at)]) else 0
  block <- array(duration[seq_len(prod(extent[1:3])) + cell * prod(extent[1:3])], extent[1:3])
  names <- as.vector(ncdf4::ncvar_get(nc, "phase"))
  drawn <- sapply(phases, function(phase) apply(block[, match(phase, names), , drop = FALSE], 1, median, na.rm = TRUE))
  par(mar = c(5, 4.5, 2.5, 1))
  colours <- c(cdb_colours[1:4], "#000000")
  matplot(seq_len(nrow(drawn)) - 1, drawn / 1000, type = "l", lty = 1, col = colours, xlab = "cycle",
          ylab = "time of a cycle, us", ylim = c(0, 1.2 * max(drawn / 1000, na.rm = TRUE)))
  legend("top", phases, col = colours, lty = 1, horiz = TRUE, bty = "n", cex = 0.8)
  title(paste(c(ncdf4::ncatt_get(nc, 0, "title")$value, unlist(place)), collapse = ", "), cex.main = 0.9)
  invisible(drawn)
}

if (sys.nframe() == 0 && length(commandArgs(trailingOnly = TRUE)) == 2) {
  arguments <- commandArgs(trailingOnly = TRUE)
  f <- cdb_figures(arguments[1])
  pdf(arguments[2], 6.4, 4.6)
  cdb_phases(arguments[1])
  for (a in f$axes$name[!f$axes$is_text]) cdb_over(f, a)
  if (!is.null(f$ratios)) cdb_ratios(f)
  for (e in unique(f$fronts$error)) cdb_errors(f, e)
  if (length(f$axes$name) > 1) cdb_stability(f, f$axes$name[1], f$axes$name[2])
  invisible(dev.off())
}
