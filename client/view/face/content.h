#pragma once
/// What a window says beside its picture, and what may be asked of it there. Values alone.
#include "timeline.h"

#include <client/view/shown_settings.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace equistream {

/// A value that the panel shows.
struct Fact {
    PanelSection section = PanelSection::source;
    std::string_view label;  ///< a string literal
    std::string value;

    bool operator==(const Fact&) const = default;
};

struct FaceContent {
    std::string loading;  ///< the source that is being opened; empty: none is, and without a picture one is asked for
    bool has_picture = false;
    std::string warning;  ///< in one line; empty: nothing is to be said
    std::string status;   ///< where the head is, and how what it sees is made
    Timeline timeline;
    double time_s = 0;         ///< of the frame that is shown
    std::int64_t frame = 0;    ///< its number
    double fraction_done = 0;  ///< of a source whose length is not known, 0 to 1
    bool is_live = false, is_paused = false;
    ShownSettings shown;
    bool has_hdr = false, has_geometry = false, records_view = false, records_head = false;
    bool knows_motion = false;        ///< the frame says what moves
    std::string decoder;              ///< of the frame; empty: it was not coded
    std::vector<Fact> facts;          ///< in the order of their sections
    std::vector<std::string> recent;  ///< sources that were opened before

    bool operator==(const FaceContent&) const = default;
};

// What is asked for by menus, panel and timeline.

struct SettingWish {
    const ShownSetting* setting = nullptr;
    std::string value;
};
struct SeekWish {
    double time_s = 0;
};
struct OpenWish {
    std::string source;
};
using FaceWish = std::variant<Action, SettingWish, SeekWish, OpenWish>;

/// Whether a word of a setting makes a difference now.
bool is_offered(const ShownSetting& setting, std::string_view word, const FaceContent& content);

}  // namespace equistream
