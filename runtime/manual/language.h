// The texts of `cdb doc`.
#pragma once

#include <string_view>

namespace cdb::manual {

extern const std::string_view kLanguageReference;
extern const std::string_view kAccuracyReference;
extern const std::string_view kResultsReference;
extern const std::string_view kTracesReference;
extern const std::string_view kOmitReference;
extern const std::string_view kLintsReference;
extern const std::string_view kDetectorsReference;
extern const std::string_view kVerdictsReference;
extern const std::string_view kNoiseReference;

}  // namespace cdb::manual
