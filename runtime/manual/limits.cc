#include "runtime/manual/limits.h"

namespace cdb::manual {

const std::string_view kLimitsReference = R"reference(WHAT A RUN MAY USE

  timeout 5 min               a run that takes longer is ended, with the status timed_out
  memory 2 GB                 a run that allocates more is ended, with the status failed, and a
                              message that names the limit

The process that starts the runs enforces the timeout, and the system enforces the memory limit, which
is set before the run begins. Either ends only that run: all other runs continue, and the data that the
run recorded before are kept. By default there is no limit. Limits apply to the run and to processes
that it starts, such as the one that settles its pile; reference runs have no limits.
  `memory` counts private memory as it is allocated, whether or not it is ever touched (RLIMIT_DATA):
the heap, anonymous mappings and the stacks of threads, 8 MB for each thread. It does not count the
program and its libraries, nor the shared memory for recorded data, whose size follows from the plan. It
is therefore an upper bound for the growth of `peak_rss`, which counts touched pages of all kinds. The
system measures `peak_rss`, also for runs that did not finish.
  A plan that cannot fit is refused before its first run, with the numbers: if its largest run needs
more memory than is available, its results need more disk space, or its cycles take more than a year.

WHAT A PLUG-IN MAY DO

Before the code of a plug-in runs, its worker permanently drops the rights that a detector does not
need. It may compute, allocate, start threads, read files and load libraries. Each of these fails with
EPERM:
  - sockets of any kind, and devices;
  - opening files for writing, and making, changing, renaming or removing them;
  - starting programs or processes, and leaving the process group, which ends with the run;
  - signals to other processes, tracing them, and raising limits.
A seccomp filter (on x86-64 and AArch64) and Landlock enforce this, each if the kernel supports it;
without them, a plug-in has your rights. A confined plug-in can still read your files, but cannot send
them anywhere. Its heap is freed at the end of the run, so that the C library detects writes past the
end of a block, and the recorded measurements are surrounded by guard pages: a run that corrupts memory
in either way is `crashed`.
  CDB_UNCONFINED_PLUGINS=1 in the environment turns the confinement off, for detectors that open a
device, such as a graphics card, and for tools that start programs. Debuggers and profilers that attach
to a worker from outside do not need it.

)reference";

}  // namespace cdb::manual
