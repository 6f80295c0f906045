#pragma once
/// What happens to viewers, a line each on standard error.
#include <programs/cli/program.h>

#include <cstdint>
#include <string>

namespace equistream::serve {

struct ViewerEvent {
    std::string what;  ///< "came", "left", "has all", "refused", ...
    int viewer = 0;    ///< counted from 1; 0: was never let in
    std::string address;
    std::int64_t bytes = 0;  ///< sent to it
    std::string detail;      ///< may be empty
};

/// In words, as JSON, or not at all, by the same option as progress.
void log_event(cli::ProgressStyle style, const ViewerEvent& event);
/// What else there is to tell.
void log_note(cli::ProgressStyle style, const std::string& text);

}  // namespace equistream::serve
