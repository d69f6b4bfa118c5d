#include "runtime/manual/cluster.h"

namespace cdb::manual {

const std::string_view kClusterReference = R"reference(A SWEEP ON MANY MACHINES

The runs of a benchmark are independent. Each writes its own shard into `out.runs`, the folder beside
the results file; many machines can fill one folder, and a merge makes `out.h5` of it. All machines
must see this folder, the current folder, cdb and the files that the scenario names under the same
paths. The results state the host of each run (`/run/host`), and its processor (`/provenance`).

Slurm

  cdb submit FILE -o out.h5

submits a job array: each task executes one part of the plan (`cdb run --shard K/N`) on one core, or
on as many as the run with the most `threads` needs. When all tasks have ended, successfully or not, a
second job merges the shards, and removes them if no run is missing. The command follows both jobs with
the progress bar of `cdb run` until they end, and prints the summary. Ctrl-C stops only the command, not
the jobs; the same command follows them again.

The number of parts is chosen so that each has about a minute of work or more, with at most four tasks
per core of the partition; `--tasks N` sets it. --partition, --time and --account are passed to sbatch.
Pass any other option of sbatch by --sbatch: `--sbatch=--mem=2G --sbatch=--constraint=epyc`. --dry-run
prints a shell script that does the same. The plan is stored on submission: later changes of FILE do not
affect it.

For timings, request nodes of one kind (--sbatch=--constraint=…), preferably exclusively (--exclusive:
one task per node). Tasks should be bound to their cores (TaskPlugin=task/cgroup with
ConstrainCores=yes in slurm.conf, or task/affinity). All detectors of a point and repeat are executed by
one task, one after the other. If runs were executed on processors with different model names, the
merge, `cdb show` and `cdb report` say so, with the number of runs on each.

What can go wrong

  - A run fails, crashes or exceeds its time limit: this is a result, as with `cdb run`. --retry
    failed,crashed,timed_out,noisy submits the tasks with such runs again, and the merge replaces only
    these runs.
  - cdb is killed in a task: the task starts it again, and it resumes; there are three attempts in all.
  - A node dies: Slurm requeues its tasks (--requeue), and finished runs are kept.
  - A task is killed or reaches its time limit: the existing shards are merged, and the command names the
    tasks and exits with status 2. The same command submits only the tasks with missing runs.
    If cdb was killed three times, a task exits with status 75, for clusters with RequeueExit=75.
  - Slurm's controller loses the merge job: the command merges the shards itself.
  - A run is executed twice, because a controller forgot that it had started a task: shards replace each
    other as a whole.
  - The file system shows new files late (NFS): the merge waits up to 90 s for missing shards.
  - The file system has no locks: cdb cannot tell whether another cdb is at work, so merged shards and
    temporary files of killed processes are not removed.

Without Slurm

Start one part for each core of each machine, then let `cdb run` execute missing runs and merge:

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
