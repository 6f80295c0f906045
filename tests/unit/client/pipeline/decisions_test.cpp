/// What the pipeline decides of a frame.
#include <equistream/error.h>

#include <client/pipeline/decisions.h>

#include <gtest/gtest.h>

#include <string>
#include <tuple>

namespace equistream {
namespace {

TEST(Decisions, OnlyWhatIsOfUseIsDecoded) {
    const auto needed = [](const PipelineChoice& choice) {
        std::string names;
        for (int role = 0; role < track_role_count; ++role)
            if (!unneeded_roles(choice)[std::size_t(role)])
                names += std::string(track_name(TrackRole(role))) + " ";
        return names;
    };
    EXPECT_EQ(needed({"mesh", "stream", "none", false}), "main depth ");
    EXPECT_EQ(needed({"mesh", "stream", "none", true}), "main depth images ");
    EXPECT_EQ(needed({"mesh", "stream", "hidden,base", false}),
              "main depth hidden hidden-depth images window window-depth window-images ");
    EXPECT_EQ(needed({"rotation", "none", "hidden,base", true}), "main window ");
    EXPECT_EQ(needed({"eye-depth", "ray", "pushpull", true}), "main images ");
}

TEST(Decisions, WhatCountsAsEarlierAsLeftAndAsTheSameWindow) {
    for (const auto& [at_s, earlier, left] : {std::tuple(9.0, true, true),
                                              {8.5, false, true},
                                              {0.0, false, true},
                                              {-0.5, false, false},
                                              {10.0, false, false},
                                              {11.0, false, false}}) {
        EXPECT_EQ(counts_as_earlier(at_s, 10), earlier) << at_s;
        EXPECT_EQ(counts_as_left(at_s, 10), left) << at_s;
    }
    const auto window = [](double longitude, double latitude) {
        return Camera(EquirectCamera{100, 80, {longitude - 0.5, longitude + 0.5, latitude - 0.4, latitude + 0.4}});
    };
    EXPECT_TRUE(mostly_overlap(window(0, 0), window(0.4, 0.3)));
    EXPECT_FALSE(mostly_overlap(window(0, 0), window(0.6, 0)));
    EXPECT_FALSE(mostly_overlap(window(0, 0), window(0, 0.5)));
    EXPECT_TRUE(mostly_overlap(window(3, 0), window(-3, 0))) << "0.28 apart, round the back";
    EXPECT_TRUE(mostly_overlap(window(0, 0), Camera(PerspectiveCamera{8, 8, 1})));
}

TEST(Decisions, MethodAndDepthFollowFromWhatThereIs) {
    const auto chosen = [](const std::string& method, const std::string& depth, const DepthOffer& offer) {
        try {
            const DepthChoice choice = choose_depth({.source = "s", .method = method, .depth = depth}, offer);
            return choice.method + " " + choice.depth;
        } catch (const InputError&) {
            return std::string("refused");
        }
    };
    const DepthOffer scene{.scene = true}, bare{.eye_without_plane = Eye::left}, video{.posed = false, .plane = true},
        folder{.folder = true, .plane = true, .eye_without_plane = Eye::left},
        stream{.plane = true, .code = DepthCodeId::w10, .eye_without_plane = Eye::left},
        lossless{.plane = true, .code = DepthCodeId::lossless, .eye_without_plane = Eye::left};
    EXPECT_EQ(chosen("", "", scene), "eye-depth ray");
    EXPECT_EQ(chosen("", "", folder), "mesh exact");
    EXPECT_EQ(chosen("", "", stream), "mesh stream");
    EXPECT_EQ(chosen("", "", bare), "rotation none");
    EXPECT_EQ(chosen("", "", video), "rotation none");
    EXPECT_EQ(chosen("mesh", "", stream), "mesh stream");
    EXPECT_EQ(chosen("rotation", "", stream), "rotation none");
    EXPECT_EQ(chosen("rotation", "exact", bare), "rotation none") << "not missed where it is not used";
    EXPECT_EQ(chosen("mesh", "exact", lossless), "mesh exact");
    for (const auto& [method, depth, offer] : {std::tuple("eye-depth", "", stream),
                                               {"mesh", "", bare},
                                               {"mesh", "ray", stream},
                                               {"mesh", "exact", stream},
                                               {"mesh", "stream", folder},
                                               {"mesh", "", video}})
        EXPECT_EQ(chosen(method, depth, offer), "refused") << method << ' ' << depth;
}

}  // namespace
}  // namespace equistream
