#include "runtime/manual/limits.h"

namespace cdb::manual {

const std::string_view kLimitsReference = R"reference(WHAT A RUN MAY USE

  timeout 5 min               a run that takes longer is ended, with the status timed_out
  memory 2 GB                 a run that allocates more is ended, with the status failed, and a
                              message that names the limit

The process that starts the runs enforces the timeout, and the system enforces the memory limit, which
is set before the run begins. Either ends that run alone: all other runs go on, and what the run
recorded before is kept. By default there is no limit. Limits hold for
the run and for what it starts, such as the process that settles its pile; reference runs have none.
  `memory` counts private memory as it is allocated, whether or not it is ever touched (RLIMIT_DATA):
the heap, anonymous mappings and the stacks of threads, 8 MB for each thread. It does not count the
program and its libraries, nor shared memory: what a run records, whose size follows from the plan. So
it is an upper bound for the growth of `peak_rss`, which counts touched pages of all kinds. `peak_rss`
is recorded for runs that ended badly as well, as the system counted it.
  A plan that cannot fit is refused before its first run, with the numbers: if its largest run needs
more memory than there is, its results more disk, or its cycles more than a year.

WHAT A PLUG-IN MAY DO

Before the code of a plug-in runs, its worker gives up, for good, what a detector does not need. It may
compute, allocate, start threads, read files and load libraries. Each of these fails with EPERM:
  - sockets of any kind, and devices;
  - opening files for writing, and making, changing, renaming or removing them;
  - starting programs or processes, and leaving the process group, which ends with the run;
  - signals to other processes, tracing them, and raising limits.
A seccomp filter (on x86-64 and AArch64) and Landlock enforce it, each where the kernel has it; without
them, a plug-in has your rights. It can still read your files, but send them nowhere. Its heap is freed
at the end of the run, so that the C library finds what was written past its memory, and pages that
cannot be touched lie around the recorded measurements: such a run is `crashed`.
  CDB_UNCONFINED_PLUGINS=1 in the environment turns the confinement off: for detectors that open a
device, such as a graphics card, and for tools that start programs. Debuggers and profilers that attach
to a worker from outside need nothing.

)reference";

}  // namespace cdb::manual
