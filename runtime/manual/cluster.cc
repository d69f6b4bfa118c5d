#include "runtime/manual/cluster.h"

namespace cdb::manual {

const std::string_view kClusterReference = R"reference(A SWEEP ON MANY MACHINES

The runs of a benchmark are independent. Each writes a shard of its own into `out.runs`, the folder
beside the results file; many machines fill one folder, and a merge makes `out.h5` of it. The folder,
the current folder, cdb and the files that a scenario names must be seen by all machines under the same
paths. Each run names its host (`/run/host`), and `/provenance` the processor.

Slurm

  cdb submit FILE -o out.h5

submits a job array: each task executes one part of the plan (`cdb run --shard K/N`) on one core, or
on as many as the run with the most `threads` needs. A second job merges when all tasks have ended, well
or not, and removes the shards if no run is missing. The command follows both until they end, with the
bar of `cdb run`, and prints the summary. Ctrl-C ends only the following: the same command follows again.

The number of parts is chosen so that each has about a minute of work or more, for four tasks a core of
the partition at most; `--tasks N` sets it. --partition, --time and --account are those of sbatch, and
any other option goes by --sbatch: `--sbatch=--mem=2G --sbatch=--constraint=epyc`. --dry-run prints a
shell script that would do the same. The plan is stored when it is submitted: later changes of FILE do
not matter to it.

For timings ask for nodes of one kind (--sbatch=--constraint=…) and, best, for nodes of your own
(--exclusive: one task a node). Tasks should be bound to their cores (TaskPlugin=task/cgroup with
ConstrainCores=yes in slurm.conf, or task/affinity). All detectors of a point and repeat are executed by
one task, one after the other. If runs were made on processors with different model names, the merge,
`cdb show` and `cdb report` say so, with the number of runs on each.

What can go wrong

  - A run fails, crashes or exceeds its time limit: this is a result, as with `cdb run`. --retry
    failed,crashed,timed_out,noisy submits the tasks with such runs again, and the merge replaces just
    these runs.
  - cdb is killed in a task: the task starts it again, up to three times. It goes on where it was.
  - A node dies: Slurm puts its tasks back into the queue (--requeue), and finished runs are kept.
  - A task is killed or meets its time limit: the merge takes what is there, and the command names the
    tasks and exits with status 2. The same command submits only the tasks with missing runs.
    After three kills of cdb a task exits with status 75, for clusters with RequeueExit=75.
  - Slurm's controller loses the merge: the command merges by itself.
  - A run is executed twice, as a controller forgot that it had started a task: shards replace each other
    as a whole.
  - The file system shows new files late (NFS): merging waits up to 90 s for missing shards.
  - The file system has no locks: nobody can tell whether another cdb is at work, so merged shards stay,
    and temporary files of killed processes too.

Without Slurm

Start one part for each core of each machine, then let `cdb run` execute what is missing and merge:

  seq 8 | parallel 'cdb run -q FILE -o out.h5 --shard {}/8'                   GNU parallel, one machine
  seq 8 | xargs -P 8 -I{} cdb run -q FILE -o out.h5 --shard {}/8              the same with xargs
  seq 64 | parallel --sshlogin 8/node1,8/node2 --wd "$PWD" \
    'cdb run -q FILE -o out.h5 --shard {}/64'                                 GNU parallel, by ssh
  for k in 1 2; do ssh node$k "cd $PWD && cdb run -q FILE -o out.h5 --shard $k/2" & done; wait
  cdb run FILE -o out.h5

`cdb merge -o out.h5 out.runs` merges without executing anything. Shards of folders that machines do
not share can be merged as well: `cdb merge -o out.h5 a.runs b.runs`.

Reference runs (`accuracy`) are executed by every part whose runs are compared with them.

)reference";

}  // namespace cdb::manual
