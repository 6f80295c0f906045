#pragma once
/// What a viewer keeps from one run to the next: settings, its window's place, and what was opened last. One JSON file
/// (docs/guide/view.md, "Settings").
#include "shown_settings.h"

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

/// On the desktop, without its border.
struct DesktopPlace {
    int left = 0, top = 0, width = 0, height = 0;

    bool operator==(const DesktopPlace&) const = default;
};

struct KeptSettings {
    static constexpr std::size_t max_recent = 10, max_recent_bytes = 4096;
    static constexpr int max_window_side = 16384;

    std::map<std::string, std::string, std::less<>> values;  ///< of rows that are kept, by their names
    std::optional<DesktopPlace> window;
    std::vector<std::string> recent;  ///< sources, the last one first; absolute, without secrets

    bool operator==(const KeptSettings&) const = default;

    /// Remembers the values of rows that differ between the two.
    void keep_changes(const ShownSettings& before, const ShownSettings& after);
    void remember(const std::string& source);
    /// Remembers what name_of gave.
    void insert(const std::string& name);
    /// As `recent` has it.
    static std::string name_of(const std::string& source);
    /// What was kept goes into `shown`.
    void apply_to(ShownSettings& shown) const;
};

/// $XDG_CONFIG_HOME/equistream/view.json, else in ~/.config; empty where there is neither.
std::filesystem::path kept_settings_file();

struct ReadSettings {
    KeptSettings kept;
    std::string note;            ///< one line on what was left out and why; empty: nothing was
    bool may_be_written = true;  ///< false: what somebody wrote there would be lost
};
/// What cannot be read, or is not known, is left out; a file that is not there has nothing.
ReadSettings read_kept_settings(const std::filesystem::path& file);

/// Changes in the file what differs from `was`, as this viewer read or wrote it last. What another viewer has written
/// since stays, and so does what this version does not know. The file is whole at any time. Throws WorkError.
void write_kept_settings(const std::filesystem::path& file, const KeptSettings& kept, const KeptSettings& was = {});

}  // namespace equistream
