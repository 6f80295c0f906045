/// The face without a window: its letters, and what comes of clicks on its parts, as the router hands them out.
#include <client/view/face/face.h>
#include <client/view/face/timeline.h>
#include <client/view/gl/pixel_probe.h>
#include <client/view/input_router.h>
#include <client/view/meters.h>
#include <tests/unit/client/gl/gl_fixture.h>

#include <client/gpu/memory.h>
#include <client/gpu/objects.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace equistream::test {
namespace {

// Letters.

/// Columns and rows of a letter in which its ink is at least half as dark as can be.
struct Ink {
    int columns = 0, rows = 0;
};

Ink ink_of(ImFontAtlas& atlas, ImWchar letter) {
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    atlas.GetTexDataAsAlpha8(&pixels, &width, &height);
    const ImFontGlyph& glyph = *atlas.Fonts[0]->FindGlyphNoFallback(letter);
    const auto at = [](float share, int side) { return int(std::lround(share * float(side))); };
    Ink ink;
    std::vector<bool> columns(std::size_t(width), false);
    for (int y = at(glyph.V0, height); y < at(glyph.V1, height); ++y) {
        bool has_ink = false;
        for (int x = at(glyph.U0, width); x < at(glyph.U1, width); ++x)
            if (pixels[y * width + x] >= 128)
                has_ink = columns[std::size_t(x)] = true;
        ink.rows += has_ink;
    }
    ink.columns = int(std::ranges::count(columns, true));
    return ink;
}

TEST(Letters, FullStopsAndDashesAreThereAtEveryScale) {
    for (const double scale : {1.0, 1.1, 1.25, 1.33, 1.5, 1.75, 2.0, 2.5, 3.0}) {
        ImFontAtlas atlas;
        const int height_px = font_height_px(scale);
        load_font(atlas, find_font(), height_px);
        ASSERT_EQ(atlas.Fonts.Size, 1);
        const Ink stop = ink_of(atlas, '.'), dash = ink_of(atlas, '-'), upright = ink_of(atlas, 'l');
        EXPECT_GE(stop.columns, 1) << scale;
        EXPECT_GE(stop.rows, 1) << scale;
        EXPECT_GE(dash.rows, 1) << scale;
        EXPECT_GE(dash.columns, height_px / 5) << scale;
        EXPECT_GE(upright.rows, height_px / 2) << scale;
        // Two dashes are no line: there is paper between them.
        const ImFontGlyph& glyph = *atlas.Fonts[0]->FindGlyphNoFallback('-');
        EXPECT_GE(glyph.AdvanceX, float(dash.columns) + 1) << scale;
    }
}

TEST(Letters, AreAsLargeAsTheDisplayAsksFor) {
    EXPECT_EQ(font_height_px(1), 15);
    EXPECT_EQ(font_height_px(2), 30);
    EXPECT_EQ(font_height_px(1.5), 23);
    EXPECT_EQ(font_height_px(0), 8) << "a display that says nothing good";
    EXPECT_EQ(font_height_px(1e9), 120);
    ImFontAtlas small, large;
    load_font(small, find_font(), 15);
    load_font(large, find_font(), 30);
    const auto ratio = double(ink_of(large, 'H').rows) / ink_of(small, 'H').rows;
    EXPECT_NEAR(ratio, 2, 0.3);
}

TEST(Letters, WithoutAFontThereAreOthers) {
    for (const FontFile& font : {FontFile{}, FontFile{"/no/such/font.ttf", 0}, FontFile{"/proc/self/exe", 0}}) {
        ImFontAtlas atlas;
        load_font(atlas, font, 30);
        EXPECT_TRUE(atlas.IsBuilt());
        EXPECT_EQ(std::fmod(atlas.Fonts[0]->FontSize, 13), 0) << "whole rows";
        EXPECT_GE(ink_of(atlas, '.').rows, 1);
    }
}

// Time on a bar.

TEST(TimelineBars, APlaceIsAFrame) {
    const Timeline four{2, 0.8, 5};
    const TimelineBar bar{10, 400};
    for (int frame = 0; frame < 4; ++frame)
        for (const float within : {0.02f, 0.5f, 0.98f})
            EXPECT_NEAR(time_at(four, bar, 10 + 100 * (float(frame) + within)), 2 + 0.2 * frame, 1e-9) << within;
    EXPECT_NEAR(time_at(four, bar, -1e6f), 2, 1e-9);
    EXPECT_NEAR(time_at(four, bar, 1e6f), 2.6, 1e-9) << "the last frame, not the end";
}

TEST(TimelineBars, TimesComeBackFromTheirPlaces) {
    const Timeline walk{0, 20, 30};
    const TimelineBar bar{7, 913};
    for (int frame = 0; frame < 600; ++frame) {
        const double middle_s = (frame + 0.5) / 30;
        EXPECT_NEAR(time_at(walk, bar, place_of(walk, bar, middle_s)), frame / 30.0, 1e-9);
    }
    EXPECT_EQ(place_of(walk, bar, -5), 7);
    EXPECT_EQ(place_of(walk, bar, 25), 920);
    EXPECT_EQ(place_of(Timeline{}, bar, 3), 7) << "its length is not known";
    EXPECT_EQ((Timeline{0, 0.001, 30}).frames(), 1);
}

TEST(Meters, CountWhatTheLastSecondsHad) {
    Meter meter(2);
    EXPECT_EQ(meter.per_second(0), 0);
    for (int i = 0; i <= 100; ++i)
        meter.add(0.1 * i, 3);
    EXPECT_NEAR(meter.per_second(10), 30, 1.5);
    EXPECT_EQ(meter.per_second(100), 0);
}

// Clicks.

constexpr gl::Size window{800, 600};

class Faces : public Gl {
protected:
    Faces() {
        face.resize(window, 1);
        content.has_picture = true;
        content.timeline = {0, 4, 10};
        face.say(content);
    }

    void feed(std::vector<InputEvent> events) {
        WindowInputs inputs;
        inputs.events = std::move(events);
        inputs.window = window;
        router.route(inputs, face, routed);
    }
    void click(float x, float y, int button = GLFW_MOUSE_BUTTON_LEFT) {
        feed({PointerEvent{x, y}, ButtonEvent{button, true}});
        feed({ButtonEvent{button, false}});
    }
    void press(int key, int modifiers = 0) {
        feed({KeyEvent{key, modifiers, true, false}, KeyEvent{key, 0, false, false}});
    }
    template <typename Wish>
    std::vector<Wish> wishes() {
        std::vector<Wish> found;
        for (const FaceWish& wish : face.take_wishes())
            if (const auto* one = std::get_if<Wish>(&wish))
                found.push_back(*one);
        return found;
    }
    /// In rows of text, about what stands in the menu bar.
    static constexpr float line = 15;

    Face face;
    FaceContent content;
    InputRouter router;
    ViewInputs routed;
};

constexpr float bar_y = 600 - 40, bar_left = 8, bar_width = 800 - 16;

TEST_F(Faces, AClickOnTheTimelineSeeks) {
    for (const int frame : {0, 13, 39}) {
        click(bar_left + bar_width * (float(frame) + 0.5f) / 40, bar_y);
        const auto sought = wishes<SeekWish>();
        ASSERT_EQ(sought.size(), 1U) << frame;
        EXPECT_NEAR(sought[0].time_s, frame / 10.0, 1e-9);
    }
    // Dragged along, it seeks again, once a frame.
    feed({PointerEvent{bar_left + 1, bar_y}, ButtonEvent{GLFW_MOUSE_BUTTON_LEFT, true}});
    feed({PointerEvent{bar_left + 2, bar_y}});
    feed({PointerEvent{bar_left + 5, bar_y}, PointerEvent{bar_left + 0.5f * bar_width + 5, bar_y}});
    feed({PointerEvent{2000, bar_y}, ButtonEvent{GLFW_MOUSE_BUTTON_LEFT, false}});
    const auto dragged = wishes<SeekWish>();
    ASSERT_EQ(dragged.size(), 3U);
    EXPECT_NEAR(dragged[1].time_s, 2, 1e-9);
    EXPECT_NEAR(dragged[2].time_s, 3.9, 1e-9);
    EXPECT_TRUE(routed.samples.empty() || routed.samples[0].drag_x == 0);
}

TEST_F(Faces, ARightClickOnThePictureSaysWhereAndOtherKeysDoNothing) {
    press(GLFW_KEY_F5);
    press(GLFW_KEY_W);  // held, not pressed
    feed({KeyEvent{GLFW_KEY_M, 0, true, true}});
    EXPECT_TRUE(routed.pressed.empty());
    feed({KeyEvent{GLFW_KEY_COMMA, 0, true, true}});
    EXPECT_EQ(routed.pressed, std::vector{Action::frame_back});
    click(400, 300);
    EXPECT_LT(routed.click_x, 0);
    click(400, 300, GLFW_MOUSE_BUTTON_RIGHT);
    EXPECT_EQ(routed.click_x, 0.5);
}

TEST_F(Faces, WhereTheLengthIsNotKnownOrItIsLiveNothingSeeks) {
    content.timeline = {};
    face.say(content);
    click(400, bar_y);
    content.timeline = {0, 4, 10};
    content.is_live = true;
    face.say(content);
    click(400, bar_y);
    EXPECT_TRUE(wishes<SeekWish>().empty());
}

TEST_F(Faces, DragsTurnTheHeadWhereTheyBeginOnThePictureAlone) {
    const auto drag_from = [&](float x, float y) {
        routed = {};
        feed({PointerEvent{x, y}, ButtonEvent{GLFW_MOUSE_BUTTON_LEFT, true}, PointerEvent{x - 30, y + 7},
              SteeringEvent{Clock::now(), {}, {}}, ButtonEvent{GLFW_MOUSE_BUTTON_LEFT, false}});
        return std::pair(routed.samples.at(0).drag_x, routed.samples.at(0).drag_y);
    };
    EXPECT_EQ(drag_from(300, 300), std::pair(-30.0, 7.0));
    EXPECT_EQ(drag_from(700, 300), std::pair(-30.0, 7.0));
    content.shown.panel = true;
    face.say(content);
    feed({PointerEvent{10, 300}});
    EXPECT_EQ(drag_from(700, 300), std::pair(0.0, 0.0)) << "over the panel";
    EXPECT_EQ(drag_from(300, 300), std::pair(-30.0, 7.0));
    EXPECT_FALSE(face.pointer_over_picture()->x > 300);
}

TEST_F(Faces, TheWheelZoomsThePictureAndScrollsThePanel) {
    content.shown.panel = true;
    face.say(content);
    feed({PointerEvent{300, 300}, WheelEvent{2}});
    EXPECT_EQ(routed.scroll, 2);
    feed({PointerEvent{700, 300}, WheelEvent{2}});
    EXPECT_EQ(routed.scroll, 2);
}

TEST_F(Faces, KeysGoToAFieldOfTextWhileItIsThere) {
    press(GLFW_KEY_M);
    EXPECT_EQ(routed.pressed, std::vector{Action::next_method});
    routed = {};
    face.ask_for_source();
    feed({PointerEvent{5, 500}});
    EXPECT_TRUE(face.has_keyboard());
    HeldActions forward;
    forward.set(std::size_t(Action::move_forward));
    feed({KeyEvent{GLFW_KEY_M, 0, true, false}, TextEvent{"/walks/m.mp4"}, SteeringEvent{Clock::now(), forward, {}}});
    EXPECT_TRUE(routed.pressed.empty());
    EXPECT_TRUE(routed.samples.at(0).held.none()) << "w is a letter here";
    press(GLFW_KEY_ENTER);
    const auto wanted = wishes<OpenWish>();
    ASSERT_EQ(wanted.size(), 1U);
    EXPECT_EQ(wanted[0].source, "/walks/m.mp4");
    EXPECT_FALSE(face.has_keyboard());
    face.ask_for_source();
    feed({PointerEvent{5, 500}});
    feed({KeyEvent{GLFW_KEY_V, GLFW_MOD_CONTROL, true, false}, TextEvent{"tls://pasted@host:9000"}});
    press(GLFW_KEY_ENTER);
    const auto pasted = wishes<OpenWish>();
    ASSERT_EQ(pasted.size(), 1U);
    EXPECT_EQ(pasted[0].source, "tls://pasted@host:9000");
    face.ask_for_source();
    press(GLFW_KEY_ESCAPE);
    EXPECT_FALSE(face.has_keyboard());
    EXPECT_TRUE(routed.pressed.empty()) << "which does not quit";
    press(GLFW_KEY_ESCAPE);
    EXPECT_EQ(routed.pressed, std::vector{Action::quit});
}

TEST_F(Faces, WhatIsDroppedIsHandedOn) {
    feed({DropEvent{"/a"}, DropEvent{"/b"}});
    EXPECT_EQ(routed.dropped, "/b");
}

TEST_F(Faces, AMenuChoosesWhatItsTableSays) {
    feed({PointerEvent{400, 300}});
    // Wherever the menu has come to lie: all places below it are tried, a line after the other.
    std::vector<std::pair<std::string, std::string>> chosen;
    for (float y = 25; y < 300; y += 4) {
        click(60, 8);  // "View"
        click(90, y);
        for (const SettingWish& wish : wishes<SettingWish>())
            if (const auto one = std::pair(std::string(wish.setting->name), wish.value);
                chosen.empty() || chosen.back() != one)
                chosen.push_back(one);
        press(GLFW_KEY_ESCAPE);
        routed = {};
    }
    EXPECT_EQ(chosen, (std::vector<std::pair<std::string, std::string>>{{"times", "on"}, {"panel", "on"}}));
}

TEST_F(Faces, ItDrawsNothingThatHidesThePictureForLong) {
    gl::Texture picture = gl::make_layered_texture(window, 1, GL_RGBA8);
    const gl::Framebuffer framebuffer = gl::make_framebuffer(std::vector{picture.name()}, 0);
    const auto inked = [&] {
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
        glViewport(0, 0, window.width, window.height);
        glClearColor(1, 0, 1, 1);
        glClear(GL_COLOR_BUFFER_BIT);
        face.draw();
        std::vector<std::uint8_t> pixels(std::size_t(4) * window.width * window.height);
        glReadPixels(0, 0, window.width, window.height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
        std::int64_t count = 0;
        for (std::size_t i = 0; i < pixels.size(); i += 4)
            count += pixels[i] != 255 || pixels[i + 1] != 0 || pixels[i + 2] != 255;
        return count;
    };
    EXPECT_GT(inked(), 800 * 40) << "menu bar and timeline";
    EXPECT_TRUE(face.is_awake());
    const auto start = Clock::now();
    while (face.is_awake() && seconds_since(start) < 60) {
    }
    EXPECT_EQ(inked(), 0);
    content.warning = "waiting for the server since 3 s";
    face.say(content);
    EXPECT_GT(inked(), 500);
    content.warning.clear();
    for (const gl::Overlay overlay : {gl::Overlay::depth, gl::Overlay::gaps, gl::Overlay::reliability}) {
        content.shown.overlay = overlay;
        face.say(content);
        EXPECT_GT(inked(), 3000) << "a legend of " << gl::overlay_names[std::size_t(overlay)];
    }
    content.shown.overlay = gl::Overlay::none;
    face.say(content);
    face.turn_help_page();
    EXPECT_GT(inked(), 50000);
    feed({PointerEvent{1, 300}});
    EXPECT_TRUE(face.is_awake());
}

TEST_F(Faces, MemoryOfTheGpuIsCounted) {
    const std::size_t before = gl::object_bytes();
    const gl::Texture texture = gl::make_layered_texture({1000, 500}, 2, GL_RGBA8);
    const gl::Buffer buffer = gl::make_buffer(std::size_t(12345), 0);
    EXPECT_EQ(gl::object_bytes() - before, 4'000'000U + 12345U);
}

TEST_F(Faces, APixelIsReadAsItIs) {
    gl::EyeTargets eyes;
    eyes.size_for({8, 6, 1.5}, 2);
    const gl::Texture depth = gl::make_layered_texture({8, 6}, 2, GL_R32F);
    const gl::Texture reliability = gl::make_layered_texture({8, 6}, 2, GL_R8);
    const auto write = [](GLuint texture, GLenum format, GLenum type, const void* value) {
        glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
        glTextureSubImage3D(texture, 0, 5, 4, 1, 1, 1, 1, format, type, value);
    };
    const std::array<std::uint8_t, 4> rgba = {10, 20, 30, 255};
    const std::uint8_t origin = 6, half = 51;
    const float inverse = 0.25f;
    write(eyes.colour(), GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
    write(eyes.origin(), GL_RED_INTEGER, GL_UNSIGNED_BYTE, &origin);
    write(depth.name(), GL_RED, GL_FLOAT, &inverse);
    write(reliability.name(), GL_RED, GL_UNSIGNED_BYTE, &half);
    gl::PixelProbe probe;
    const auto read = [&](const gl::ShownPixel& pixel, const gl::EyeDepth& known, GLuint trusted) {
        probe.ask(pixel, eyes, known, trusted);
        std::optional<gl::PixelValues> values;
        while (probe.is_waiting() && !values)
            values = probe.take();
        return values;
    };
    const auto all = read({1, 5, 4}, {depth.name(), 2}, reliability.name());
    ASSERT_TRUE(all);
    EXPECT_EQ(all->rgba, rgba);
    EXPECT_EQ(all->origin, origin);
    EXPECT_EQ(all->inverse_m, 0.5f);
    EXPECT_NEAR(*all->reliability, 0.2f, 1e-6);
    const auto without = read({1, 5, 4}, {}, 0);
    ASSERT_TRUE(without);
    EXPECT_EQ(without->rgba, rgba);
    EXPECT_FALSE(without->inverse_m || without->reliability);
    for (const gl::ShownPixel& beyond : {gl::ShownPixel{2, 0, 0}, {0, 8, 0}, {0, 0, 6}, {0, -1, 0}})
        EXPECT_FALSE(read(beyond, {}, 0));
}

TEST(ShownPixels, ALayoutSaysWhichEyesPixelIsWhere) {
    using Layout = gl::DisplayLayout;
    const auto at = [](Layout layout, int x, int y) { return gl::shown_pixel(layout, {200, 100}, x, y); };
    EXPECT_EQ(at(Layout::left, 150, 20), (gl::ShownPixel{0, 150, 20}));
    EXPECT_EQ(at(Layout::right, 150, 20), (gl::ShownPixel{0, 150, 20})) << "its only one";
    EXPECT_EQ(at(Layout::side_by_side, 99, 0), (gl::ShownPixel{0, 99, 0}));
    EXPECT_EQ(at(Layout::side_by_side, 150, 20), (gl::ShownPixel{1, 50, 20}));
    EXPECT_EQ(at(Layout::headset, 150, 20), std::nullopt);
    EXPECT_EQ(at(Layout::sphere, 150, 20), std::nullopt);
    EXPECT_EQ(at(Layout::left, 200, 20), std::nullopt);
    EXPECT_EQ(at(Layout::left, 0, -1), std::nullopt);
}

}  // namespace
}  // namespace equistream::test
