#include "compiler/schema/result_names.h"

#include <fmt/format.h>

#include "compiler/schema/schema.h"

namespace cdb::schema {
namespace {

constexpr bool kOnlyWithErrors = true;

constexpr ResultNames kNames[] = {
    {"a dimension of the results",
     "rep phase cycle body pose box_body bound filter contact_row contact_side xyz"},
    {"a series of the results",
     "duration pairs manifolds contacts kinetic_energy energy max_penetration penetration_ratio "
     "max_speed escaped asleep removed non_finite displacement displaced motion_ratio "
     "fall_ratio frozen lost_way turn_ratio spin_ratio passed pressed inverted unheld lost_energy "
     "heap joint_gap poses boxes box_filters exact_pairs missed_pairs phantom_pairs "
     "duplicate_pairs exact_contacts missed_contacts unsure_contacts depth_error normal_error"},
    {"an array of contacts in the results",
     "contact_body contact_point contact_normal contact_distance contact_first"},
    {"a fact of each run in the results",
     "status verdict first_bad_cycle n_cycles started load_average noise noise_cause cycles_time "
     "cpu_time preemptions page_faults steal other_time "
     "processors attempts peak_rss place_time build_time harness fill_fraction state_hash run_id "
     "host message omitted needs"},
    {"a group of the results", "run accuracy provenance"},
    {"an array of /accuracy in the results", "sample horizon step_size truth", kOnlyWithErrors},
};

}  // namespace

std::span<const ResultNames> ReservedNames() { return kNames; }

std::optional<std::string> FindNameClash(std::string_view axis,
                                         std::span<const ErrorInfo* const> errors) {
  for (const ResultNames& row : kNames)
    if (ListsWord(row.names, axis) && (!row.only_with_errors || !errors.empty()))
      return std::string(row.kind);
  for (const ErrorInfo* error : errors)
    for (const char* ending : {"", "_floor", "_series"})
      if (axis == fmt::format("{}{}", error->name, ending))
        return fmt::format("an error of accuracy.metrics {}", error->metric);
  return std::nullopt;
}

}  // namespace cdb::schema
