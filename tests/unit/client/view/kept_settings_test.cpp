/// What is kept comes back, and no file keeps the viewer from starting.
#include <client/view/kept_settings.h>

#include <equistream/error.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace equistream::test {
namespace {

namespace fs = std::filesystem;

class Kept : public testing::Test {
protected:
    Kept() { fs::create_directories(folder); }
    ~Kept() override { fs::remove_all(folder); }

    ReadSettings read(const std::string& text) const {
        std::ofstream(file, std::ios::binary) << text;
        return read_kept_settings(file);
    }

    const fs::path folder = fs::temp_directory_path() / ("equistream_kept_" + std::to_string(getpid()));
    const fs::path file = folder / "view.json";
};

TEST_F(Kept, ComesBackAsItWas) {
    KeptSettings kept;
    ShownSettings changed;
    changed.layout = gl::DisplayLayout::side_by_side;
    changed.overlay = gl::Overlay::depth;
    changed.fill_chain = "hidden,pushpull";
    changed.loop = false;
    changed.exposure_stops = 3;  // the stream's
    kept.keep_changes({}, changed);
    EXPECT_EQ(kept.values.size(), 4U);
    kept.window = DesktopPlace{-10, 20, 640, 360};
    kept.remember("/walks/bel\xc3\xa9m.mp4");
    const fs::path deep = folder / "config" / "equistream" / "view.json";
    write_kept_settings(deep, kept);
    const ReadSettings read = read_kept_settings(deep);
    EXPECT_EQ(read.note, "");
    EXPECT_EQ(read.kept, kept);
    ShownSettings shown;
    read.kept.apply_to(shown);
    changed.exposure_stops = 0;
    EXPECT_EQ(shown, changed);
    EXPECT_EQ(std::distance(fs::directory_iterator(deep.parent_path()), fs::directory_iterator()), 1)
        << "nothing is left beside it";
}

TEST_F(Kept, WhatAKeyHidesComesBackWithIt) {
    const ShownSetting &fill = *find_shown_setting("fill"), &method = *find_shown_setting("method");
    ShownSettings chosen;
    fill.set(chosen, "hidden,pushpull");
    method.set(chosen, "mesh-plain");
    ShownSettings hidden = chosen;
    fill.set(hidden, fill.next(hidden));
    method.set(hidden, method.next(hidden));
    KeptSettings kept;
    kept.keep_changes({}, chosen);
    kept.keep_changes(chosen, hidden);
    write_kept_settings(file, kept);
    const ReadSettings read = read_kept_settings(file);
    EXPECT_EQ(read.note, "");
    ShownSettings shown;
    read.kept.apply_to(shown);
    EXPECT_EQ(shown, hidden);
    EXPECT_EQ(fill.next(shown), "hidden,pushpull");
    EXPECT_EQ(method.next(shown), "mesh-plain");
    kept.keep_changes(hidden, {});
    ShownSettings again;
    kept.apply_to(again);
    EXPECT_EQ(again, ShownSettings()) << "what was hidden is no longer chosen";
}

TEST_F(Kept, WhatIsNotKnownIsLeftOutInOneLine) {
    const ReadSettings read = this->read(R"({"settings": {"layout": "right", "overlay": "stripes", "layot": "left",
        "exposure": "2", "loop": false}, "window": {"left": 0, "top": 0, "width": 0, "height": 5},
        "recent": ["/a", 7], "colour": 1})");
    EXPECT_EQ(read.kept.values.size(), 1U);
    EXPECT_EQ(read.kept.values.at("layout"), "right");
    EXPECT_FALSE(read.kept.window);
    EXPECT_EQ(read.kept.recent, std::vector<std::string>{"/a"});
    EXPECT_EQ(read.note.find('\n'), read.note.npos);
    for (const char* part : {file.c_str(), "settings.overlay", "settings.layot", "settings.exposure", "settings.loop",
                             "window", "recent", "colour"})
        EXPECT_NE(read.note.find(part), read.note.npos) << part << " in: " << read.note;
}

TEST_F(Kept, DamagedFilesGiveDefaultsAndOneLine) {
    const std::string deep(40000, '[');
    for (const std::string& text :
         {std::string(), std::string("{"), std::string("[]"), std::string("\xff\xfe"), std::string("null"), deep,
          "{\"settings\": {}}" + std::string(1 << 17, ' '), std::string("{\"settings\": {\"layout\": \"right\"}")}) {
        const ReadSettings read = this->read(text);
        EXPECT_EQ(read.kept, KeptSettings());
        EXPECT_NE(read.note.find("the defaults are used"), read.note.npos) << read.note;
        EXPECT_EQ(read.note.find('\n'), read.note.npos);
    }
    EXPECT_EQ(this->read("{}").note, "");
    EXPECT_EQ(read_kept_settings(folder / "none.json").note, "");
    // Each byte of a good one may be another: it is read or it is not.
    KeptSettings kept;
    kept.values["layout"] = "sbs";
    kept.window = DesktopPlace{1, 2, 3, 4};
    kept.remember("/a");
    write_kept_settings(file, kept);
    std::ifstream stream(file);
    const std::string good{std::istreambuf_iterator<char>(stream), {}};
    for (std::size_t i = 0; i < good.size(); ++i) {
        std::string bad = good;
        bad[i] = char(bad[i] ^ 0x15);
        EXPECT_NO_THROW(this->read(bad));
        EXPECT_NO_THROW(this->read(good.substr(0, i)));
    }
}

/// Two viewers, and a version that knows more.
TEST_F(Kept, WhatOthersWroteStays) {
    const KeptSettings was =
        read(R"({"settings": {"layout": "right", "warmth": "9"}, "recent": ["/b", "/a"], "pen": 1})").kept;
    KeptSettings first = was, second = was;
    first.values["layout"] = "sbs";
    first.insert("/c");
    first.window = DesktopPlace{1, 2, 3, 4};
    second.values["fill"] = "off";
    second.insert("/a");
    write_kept_settings(file, first, was);
    write_kept_settings(file, second, was);
    const KeptSettings both = read_kept_settings(file).kept;
    EXPECT_EQ(both.values.at("layout"), "sbs");
    EXPECT_EQ(both.values.at("fill"), "off");
    EXPECT_EQ(both.window, first.window);
    EXPECT_EQ(both.recent, (std::vector<std::string>{"/a", "/c", "/b"}));
    std::ifstream stream(file);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    EXPECT_NE(text.find("\"warmth\": \"9\""), text.npos) << text;
    EXPECT_NE(text.find("\"pen\": 1"), text.npos) << text;
}

TEST_F(Kept, ListsTheLastSourcesOnceAndWithoutSecrets) {
    KeptSettings kept;
    for (int i = 0; i < 12; ++i)
        kept.remember("/walk." + std::to_string(i));
    kept.remember("/walk.5");
    EXPECT_EQ(kept.recent.size(), KeptSettings::max_recent);
    EXPECT_EQ(kept.recent[0], "/walk.5");
    EXPECT_EQ(kept.recent[1], "/walk.11");
    kept.remember("tls://word@host:9000");
    EXPECT_EQ(kept.recent[0], "tls://host:9000");
    kept.remember("walk.mp4");
    EXPECT_EQ(kept.recent[0], (fs::current_path() / "walk.mp4").string());
    const std::vector<std::string> before = kept.recent;
    kept.remember("/bad\xff");
    kept.remember("/" + std::string(KeptSettings::max_recent_bytes, 'a'));
    EXPECT_EQ(kept.recent, before);
}

TEST_F(Kept, ReadsNoMoreSourcesThanItKeeps) {
    std::string names;
    for (int i = 0; i < 12; ++i)
        names += (i > 0 ? R"(,"/)" : R"("/)") + std::to_string(i) + '"';
    EXPECT_EQ(read(R"({"recent": [)" + names + "]}").kept.recent.size(), KeptSettings::max_recent);
}

TEST_F(Kept, WhereItIs) {
    setenv("XDG_CONFIG_HOME", "/somewhere", 1);
    EXPECT_EQ(kept_settings_file(), "/somewhere/equistream/view.json");
    setenv("XDG_CONFIG_HOME", "relative", 1);
    setenv("HOME", "/home/me", 1);
    EXPECT_EQ(kept_settings_file(), "/home/me/.config/equistream/view.json");
    unsetenv("XDG_CONFIG_HOME");
    unsetenv("HOME");
    EXPECT_EQ(kept_settings_file(), "");
}

TEST_F(Kept, WhatCannotBeWrittenIsAnError) {
    std::ofstream(folder / "a_file") << "x";
    EXPECT_THROW(write_kept_settings(folder / "a_file" / "view.json", {}), std::exception);
}

}  // namespace
}  // namespace equistream::test
