#pragma once
/// Names of stages as options give them.
#include <client/stages/stages.h>

#include <cstdio>
#include <string>

namespace equistream {

/// The name that `stage` has now; an old name in `given` is answered by one line on stderr.
inline std::string current_name(const char* command, const char* option, const Stage& stage, const std::string& given) {
    if (const std::string note = renamed_note(stage, given, option); !note.empty())
        std::fprintf(stderr, "%s: %s\n", command, note.c_str());
    return std::string(stage.name);
}

}  // namespace equistream
