#pragma once
/// The file that --settings names.
#include <CLI/CLI.hpp>

namespace equistream::cli {

/// Reads lines of option = value as CLI11 does. A key that `app` has no option for is an InputError that names file,
/// line and the options there are.
class SettingsFile : public CLI::ConfigBase {
public:
    explicit SettingsFile(const CLI::App& app) : app_(app) {}
    std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;

private:
    const CLI::App& app_;  // it owns us
};

}  // namespace equistream::cli
