/// The table of settings: what an option, a key and the file of settings change is the same.
#include <client/view/shown_settings.h>

#include <equistream/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

namespace equistream::test {
namespace {

TEST(ShownSettings, EachHasItsNameItsKeyAndAPlace) {
    std::set<std::string_view> names;
    std::set<Action> keys;
    for (const ShownSetting& setting : shown_settings()) {
        EXPECT_TRUE(names.insert(setting.name).second) << setting.name;
        EXPECT_EQ(find_shown_setting(setting.name), &setting);
        EXPECT_NE(setting.menu, SettingMenu::none) << setting.name;
        EXPECT_FALSE(setting.label.empty());
        EXPECT_EQ(setting.option == SettingOption::none, setting.help.empty()) << setting.name;
        if (setting.key) {
            EXPECT_TRUE(keys.insert(*setting.key).second) << setting.name;
            EXPECT_EQ(shown_setting_of(*setting.key), &setting);
        }
        EXPECT_EQ(setting.words.empty(), setting.least < setting.most) << setting.name << ": words, or a number";
    }
    EXPECT_EQ(find_shown_setting("layot"), nullptr);
    EXPECT_EQ(shown_setting_of(Action::quit), nullptr);
}

TEST(ShownSettings, WhatIsSaidIsWhatIsTaken) {
    for (const ShownSetting& setting : shown_settings())
        for (const std::string_view word : setting.words) {
            ShownSettings shown;
            EXPECT_TRUE(setting.set(shown, std::string(word)).empty());
            EXPECT_EQ(setting.value(shown), word) << setting.name;
            ShownSettings again;
            setting.set(again, setting.value(shown));
            EXPECT_EQ(again, shown) << setting.name << " " << word;
        }
}

TEST(ShownSettings, OtherWordsAreRefusedByTheOptionsName) {
    for (const ShownSetting& setting : shown_settings()) {
        ShownSettings shown;
        try {
            setting.set(shown, "upside-down");
            ADD_FAILURE() << setting.name;
        } catch (const InputError& error) {
            EXPECT_EQ(std::string(error.what()).rfind("--" + std::string(setting.name), 0), 0U) << error.what();
        }
        EXPECT_EQ(shown, ShownSettings()) << setting.name;
    }
}

TEST(ShownSettings, AKeyGoesThroughAllWordsAndComesBack) {
    for (const ShownSetting& setting : shown_settings()) {
        if (!setting.key)
            continue;
        ShownSettings shown;
        const std::string first = setting.value(shown);
        std::set<std::string> seen;
        do {
            EXPECT_TRUE(seen.insert(setting.value(shown)).second) << setting.name;
            setting.set(shown, setting.next(shown));
        } while (setting.value(shown) != first && seen.size() < 20);
        EXPECT_EQ(shown, ShownSettings()) << setting.name;
        EXPECT_EQ(seen.size(), setting.next_value ? 2 : setting.words.size()) << setting.name;
    }
}

TEST(ShownSettings, AMethodTakesItsDepthFromWhereItLies) {
    const ShownSetting& method = *find_shown_setting("method");
    ShownSettings shown;
    method.set(shown, "eye-depth");
    EXPECT_TRUE(shown.by_depth && shown.by_geometry);
    method.set(shown, "rotation");
    EXPECT_FALSE(shown.by_depth);
    EXPECT_EQ(method.next(shown), "eye-depth") << "as it was";
    method.set(shown, "mesh-plain");
    EXPECT_TRUE(shown.by_depth && !shown.by_geometry && shown.engine == "mesh-plain");
    EXPECT_EQ(method.set(shown, "sphere").size(), 1U) << "an old name is said";
    EXPECT_THROW(method.set(shown, "splat"), InputError) << "which the GPU does not have";
}

TEST(ShownSettings, AChainThatWasChosenComesBackWithItsKey) {
    const ShownSetting& fill = *find_shown_setting("fill");
    ShownSettings shown;
    fill.set(shown, "hidden,pushpull");
    EXPECT_EQ(fill.value(shown), "hidden,pushpull");
    fill.set(shown, fill.next(shown));
    EXPECT_EQ(fill.value(shown), "off");
    fill.set(shown, fill.next(shown));
    EXPECT_EQ(fill.value(shown), "hidden,pushpull");
    fill.set(shown, "on");
    EXPECT_EQ(shown, ShownSettings());
    EXPECT_THROW(fill.set(shown, "hidden,putty"), InputError);
    EXPECT_EQ(fill.set(shown, "spread,pushpull").size(), 1U) << "a pass that the GPU does not have is said";
}

}  // namespace
}  // namespace equistream::test
