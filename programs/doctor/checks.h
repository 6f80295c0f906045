#pragma once
/// The table of what `equistream doctor` looks for. A new check is one row.
#include "finding.h"

#include <programs/cli/process.h>

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace equistream::doctor {

/// Where checks look, and what they may take.
struct Surroundings {
    std::filesystem::path programs = cli::own_folder();
    double limit_s = 30;  ///< of each child
    cli::ScratchFolder scratch{"doctor"};
};

struct Check {
    std::string_view name;
    std::string_view purpose;  ///< which commands need it
    bool is_needed;            ///< by the core commands: without it doctor fails
    std::string_view get;      ///< how to get it, in a line
    /// Does not throw for what is missing or broken. Null: equistream-probe has a probe of this name.
    Finding (*find)(const Surroundings&);
};

std::span<const Check> all_checks();

/// A check's finding, whatever happens to the programs that it runs.
Finding found_by(const Check& check, const Surroundings& surroundings);

}  // namespace equistream::doctor
