#pragma once
/// The file that --settings names, for CLI11.
#include <functional>
#include <map>
#include <memory>
#include <string>

namespace CLI {
class App;
class Config;
}  // namespace CLI

namespace equistream::cli {

/// Where the values of options were read, "b.ini:2", by the options' long names. Those that the command line gives are
/// not in it.
using SettingsPlaces = std::map<std::string, std::string, std::less<>>;

/// Reads the file for `app`, which owns it, and fills `places`, which outlives it.
std::shared_ptr<CLI::Config> settings_file(const CLI::App& app, SettingsPlaces& places);

/// The message behind the place that the option which it begins with was read from, if it was.
std::string with_place(const std::string& message, const SettingsPlaces& places);

}  // namespace equistream::cli
