#pragma once
/// The file that --settings names.
#include <CLI/CLI.hpp>

namespace equistream::cli {

/// Reads lines of option = value as CLI11 does. Lines in the section of a command, [play] say, are that command's
/// alone, so that one file serves several. A key that `app` has no option for is an InputError that names file, line
/// and the options there are.
class SettingsFile : public CLI::ConfigBase {
public:
    explicit SettingsFile(const CLI::App& app) : app_(app) {}
    std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;

private:
    /// `place` is its name with its section's, as in the file's `text`.
    void require_known(const CLI::ConfigItem& item, const std::string& place, const std::string& text) const;

    const CLI::App& app_;  // it owns us
};

}  // namespace equistream::cli
