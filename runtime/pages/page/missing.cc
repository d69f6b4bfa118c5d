// Replaces the bundled pages in a build without npm.
#include "runtime/pages/page/page.h"

namespace cdb::page {

const Template& ReportTemplate() {
  static const Template none;
  return none;
}
const Template& ViewTemplate() { return ReportTemplate(); }
const Template& EditTemplate() { return ReportTemplate(); }

}  // namespace cdb::page
