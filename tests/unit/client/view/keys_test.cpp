#include <client/view/keys.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

namespace equistream::test {
namespace {

TEST(Keys, EachDoesOneThingAndIsNamedOnce) {
    std::set<std::pair<int, int>> keys;
    std::set<std::string_view> names;
    for (const KeyBinding& b : key_bindings()) {
        EXPECT_TRUE(keys.emplace(b.key, b.modifiers).second) << b.name;
        EXPECT_TRUE(names.insert(b.name).second) << b.name;
        EXPECT_FALSE(b.help.empty()) << b.name;
        EXPECT_EQ(binding_of(b.key, b.modifiers), &b);
    }
}

TEST(Keys, EveryActionHasOne) {
    for (int action = 0; action <= int(Action::quit); ++action)
        EXPECT_TRUE(std::ranges::any_of(key_bindings(), [&](const KeyBinding& b) {
            return b.action == Action(action);
        })) << action;
    EXPECT_EQ(key_of(Action::help).name, "h");
}

TEST(Keys, OthersAreBoundToNothing) {
    EXPECT_EQ(binding_of(GLFW_KEY_F5, 0), nullptr);
    EXPECT_EQ(binding_of(GLFW_KEY_H, GLFW_MOD_CONTROL), nullptr);
}

/// The text that --keys prints and the table that handles them name the same tasks, in one piece each.
TEST(Keys, HelpHasALineForEachUnderItsTask) {
    const std::string help = key_help();
    std::set<std::string_view> tasks;
    for (const KeyBinding& b : key_bindings()) {
        tasks.insert(b.task);
        EXPECT_NE(help.find("  " + std::string(b.name) + " "), std::string::npos) << b.name;
        EXPECT_NE(help.find(std::string(b.help) + "\n"), std::string::npos) << b.name;
    }
    const auto lines = std::size_t(std::ranges::count(help, '\n'));
    EXPECT_EQ(lines, key_bindings().size() + 2 * tasks.size() - 1);
}

}  // namespace
}  // namespace equistream::test
