#include "synthetic.h"

#include <equistream/error.h>
#include <equistream/stream.h>
#include <tests/unit/atlas_fixture.h>

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

namespace equistream {
namespace {

constexpr std::size_t header_bytes = 20;  // UUID, version, size
// Appended one after the other; each with all that come after it.
constexpr std::size_t packing_bytes = 1;
constexpr std::size_t denoiser_bytes = 1 + 4 + packing_bytes;
constexpr std::size_t moving_bytes = 2 + denoiser_bytes;  // size: nothing moves in a small view's pictures
constexpr std::size_t visible_loss_bytes = 1 + 8 + moving_bytes;
constexpr std::size_t crf_bytes = 4 + visible_loss_bytes;
constexpr std::size_t halved_bytes = 1 + crf_bytes;
constexpr std::size_t patches_bytes = 2 + 6 + 5 * 12 + 9 + halved_bytes;  // size; numbers, offsets, slots as below
constexpr std::size_t depth_code_bytes = 23 + patches_bytes;
constexpr std::size_t geometry_bytes = 17 + depth_code_bytes;  // its length and 16 digits

/// Four slots of 2 + 3 + 6 + 5 bits, one of 2 and one of 1.
PatchAtlas full_atlas() {
    PatchAtlas atlas = testing::random_atlas(3, 2, 1);
    atlas.sphere_width = 960;
    atlas.sphere_height = 480;
    atlas.range = {-2.5, 3.0, -0.7, 1.1};
    atlas.offsets_m.resize(5);
    atlas.slots = {{1, 59, 29, true}, {0, 3, 4, true}, {0, 3, 5, true}, {}, {4, 0, 0, true}, {2, 31, 17, true}};
    return atlas;
}

FrameInfo full_info() {
    FrameInfo info;
    info.index = max_frame_index;
    info.time_s = 1.8e9 + 4.0 / 30;
    info.frames_per_second = 29.97;
    info.camera = EquirectCamera{960, 480, {-2.5, 3.0, -0.7, 1.1}};
    info.camera_pose = {{0.1, -2.25, 1e-9}, glm::normalize(glm::dquat(0.5, -0.1, 0.7, 0.2))};
    info.head = {{7, 8, 9}, glm::normalize(glm::dquat(-0.3, 0.1, 0.2, 0.9))};
    info.eye = Eye::right;
    info.ipd_m = 0.0641;
    info.lock = AxisLock::path;
    info.head_radius_m = 0.25;
    info.exposure = 3.75;
    info.seed = 0xfedcba9876543210u;
    info.samples_per_pixel = 4000000000u;
    info.scene = "san-miguel \xc3\xa9";
    info.host = std::string(255, 'h');
    info.geometry_fingerprint = "0123456789abcdef";
    info.denoiser = "oidn";
    info.depth_code = DepthCodeInfo{DepthCodeId::w12, {0.2815, 0.75, true}, 4000000001u, true};
    info.patches = full_atlas();
    info.crf = 27.25f;
    info.visible_loss = VisibleLoss{{0, 255, 3, 4, 128, 6, 7, 8}};
    return info;
}

std::vector<std::uint8_t> full_payload() {
    return encode_frame_info(TrackRole::patches, full_info(), {17, 90});
}

template <typename T>
void overwrite(std::vector<std::uint8_t>& payload, std::size_t offset, T value) {
    ASSERT_LE(offset + sizeof value, payload.size());
    std::memcpy(payload.data() + offset, &value, sizeof value);
}

TEST(FrameInfoPayload, EveryFieldComesBack) {
    const auto tagged = decode_frame_info(full_payload());
    ASSERT_TRUE(tagged);
    EXPECT_EQ(tagged->role, TrackRole::patches);
    EXPECT_EQ(tagged->position.ordinal, 17u);
    EXPECT_EQ(tagged->position.count, 90u);
    expect_same_info(tagged->info, full_info());
}

TEST(FrameInfoPayload, PerspectiveCameraComesBack) {
    FrameInfo info;
    info.camera = PerspectiveCamera{640, 360, 1.25};
    const auto tagged = decode_frame_info(encode_frame_info(TrackRole::main, info));
    ASSERT_TRUE(tagged);
    expect_same_info(tagged->info, info);
}

TEST(FrameInfoPayload, BothEyesLieInPicturesOfMainAndItsDepthAlone) {
    FrameInfo info = full_info();
    info.patches.reset();
    info.depth_code.reset();
    for (const StereoPacking packing : {StereoPacking::side_by_side, StereoPacking::top_bottom}) {
        info.packing = packing;
        for (const TrackRole role : {TrackRole::main, TrackRole::depth}) {
            const auto tagged = decode_frame_info(encode_frame_info(role, info));
            ASSERT_TRUE(tagged);
            EXPECT_EQ(tagged->info.packing, packing);
        }
        EXPECT_THROW(decode_frame_info(encode_frame_info(TrackRole::hidden, info)), WorkError);
    }
    auto payload = encode_frame_info(TrackRole::main, info);
    payload.back() = 3;
    EXPECT_THROW(decode_frame_info(payload), WorkError);
}

TEST(FrameInfoPayload, ATableOfPatchesLiesInTheirPicturesAlone) {
    FrameInfo info = full_info();
    info.depth_code.reset();
    auto payload = encode_frame_info(TrackRole::patches, info);
    for (int role = 0; role < track_role_count; ++role) {
        payload[20] = std::uint8_t(role);
        if (TrackRole(role) == TrackRole::patches || TrackRole(role) == TrackRole::patches_depth) {
            EXPECT_TRUE(decode_frame_info(payload)->info.patches);
            continue;
        }
        EXPECT_THROW(decode_frame_info(payload), WorkError) << track_name(TrackRole(role));
        EXPECT_THROW(encode_frame_info(TrackRole(role), info), InputError) << track_name(TrackRole(role));
    }
}

TEST(FrameInfoPayload, OmnidirectionalStereoComesBackWithItsEye) {
    FrameInfo info = full_info();
    info.patches.reset();
    info.depth_code.reset();
    for (const Eye eye : {Eye::left, Eye::right}) {
        info.eye = eye;
        std::get<EquirectCamera>(info.camera).ods_side_m = (eye == Eye::left ? -0.5 : 0.5) * 0.0641;
        auto payload = encode_frame_info(TrackRole::main, info);
        EXPECT_EQ(payload[21], 2);
        const auto tagged = decode_frame_info(payload);
        ASSERT_TRUE(tagged);
        expect_same_info(tagged->info, info);
        EXPECT_EQ(std::get<EquirectCamera>(tagged->info.camera).ods_side_m,
                  std::get<EquirectCamera>(info.camera).ods_side_m);
        payload[22] = 0;
        EXPECT_THROW(decode_frame_info(payload), WorkError) << "no eye turns around itself";
    }
}

TEST(FrameInfoPayload, HasTheDocumentedLayout) {
    const auto payload = full_payload();
    EXPECT_EQ(payload[0], 0x69);
    EXPECT_EQ(payload[15], 0x19);
    EXPECT_EQ(payload[16], 1);  // version, little-endian
    EXPECT_EQ(payload[17], 0);
    EXPECT_EQ(payload[18] + 256 * payload[19], static_cast<int>(payload.size() - header_bytes));
    EXPECT_EQ(payload[20], 5);                        // role patches
    EXPECT_EQ(payload[22], 2);                        // eye right
    EXPECT_EQ(payload[24] + 256 * payload[25], 960);  // width
    EXPECT_EQ(payload[32], 17);                       // ordinal
    EXPECT_EQ(payload[40], 0xff);                     // index 0x3b9ac9ff
    EXPECT_EQ(payload.size(), header_bytes + 224 + 1 + full_info().scene.size() + 1 + 255 + 1 + 16 + depth_code_bytes);
}

TEST(FrameInfoPayload, ForeignPayloadsAreNotOurs) {
    EXPECT_FALSE(decode_frame_info({}));
    auto payload = full_payload();
    for (std::size_t i = 0; i < 16; ++i) {
        payload = full_payload();
        payload[i] ^= 1;
        EXPECT_FALSE(decode_frame_info(payload));
    }
}

TEST(FrameInfoPayload, IsFoundBehindAnEncodersOwnUuid) {
    std::vector<std::uint8_t> payload(16, 0x2c);
    const auto ours = full_payload();
    payload.insert(payload.end(), ours.begin(), ours.end());
    const auto tagged = decode_frame_info(payload);
    ASSERT_TRUE(tagged);
    expect_same_info(tagged->info, full_info());
}

TEST(FrameInfoPayload, TruncationAtEveryByteIsAnError) {
    const auto payload = full_payload();
    for (std::size_t size = 0; size < payload.size(); ++size) {
        // An exact-size buffer, so that a sanitiser sees any read beyond it.
        const std::vector<std::uint8_t> cut(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(size));
        if (size < 16)
            EXPECT_FALSE(decode_frame_info(cut)) << size;
        else
            EXPECT_THROW(decode_frame_info(cut), WorkError) << size;
    }
}

TEST(FrameInfoPayload, ShorterDeclaredSizeIsAnErrorToo) {
    const auto payload = full_payload();
    for (std::size_t size = 0; size + header_bytes < payload.size(); ++size) {
        auto shortened = payload;
        overwrite(shortened, 18, static_cast<std::uint16_t>(size));
        if (size + geometry_bytes + header_bytes == payload.size() ||
            size + depth_code_bytes + header_bytes == payload.size() ||
            size + patches_bytes + header_bytes == payload.size() ||
            size + halved_bytes + header_bytes == payload.size() || size + crf_bytes + header_bytes == payload.size() ||
            size + visible_loss_bytes + header_bytes == payload.size() ||
            size + moving_bytes + header_bytes == payload.size() ||
            size + denoiser_bytes + header_bytes == payload.size() ||
            size + packing_bytes + header_bytes == payload.size())
            continue;  // as earlier streams are
        EXPECT_THROW(decode_frame_info(shortened), WorkError) << size;
    }
}

TEST(FrameInfoPayload, EarlierStreamsLackWhatWasAppended) {
    FrameInfo expected = full_info();
    for (const std::size_t left_out : {packing_bytes, denoiser_bytes, moving_bytes, visible_loss_bytes, crf_bytes,
                                       halved_bytes, patches_bytes, depth_code_bytes, geometry_bytes}) {
        auto payload = full_payload();
        payload.resize(payload.size() - left_out);
        overwrite(payload, 18, static_cast<std::uint16_t>(payload.size() - header_bytes));
        const auto tagged = decode_frame_info(payload);
        ASSERT_TRUE(tagged);
        if (left_out >= denoiser_bytes)
            expected.denoiser.clear();
        if (left_out >= visible_loss_bytes)
            expected.visible_loss.reset();
        if (left_out >= crf_bytes)
            expected.crf.reset();
        if (expected.depth_code && left_out >= halved_bytes)
            expected.depth_code->halved = false;
        if (left_out >= patches_bytes)
            expected.patches.reset();
        if (left_out >= depth_code_bytes)
            expected.depth_code.reset();
        if (left_out == geometry_bytes)
            expected.geometry_fingerprint.clear();
        expect_same_info(tagged->info, expected);
    }
}

TEST(FrameInfoPayload, HostileDepthCodesAreErrors) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto refuses = [](std::size_t offset, auto value, const char* named) {
        auto payload = full_payload();
        overwrite(payload, payload.size() - depth_code_bytes + offset, value);
        try {
            decode_frame_info(payload);
            ADD_FAILURE() << "accepted " << named;
        } catch (const WorkError& error) {
            EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        }
    };
    refuses(0, std::uint8_t{2}, "whether depth is coded");
    refuses(1, std::uint8_t{7}, "depth code");
    refuses(2, std::uint8_t{2}, "no surface");
    refuses(3, nan, "head box radius");
    refuses(3, 0.0, "head box radius");
    refuses(3, 0.75, "nearest depth outside");
    refuses(11, nan, "nearest depth");
    refuses(11, -1.0, "nearest depth");
    refuses(11, 0.2815, "nearest depth outside");
    refuses(11, std::nextafter(0.2815, 1.0), "nearest depth outside");  // the same as a float
    refuses(11, 1e300, "nearest depth outside");
    refuses(depth_code_bytes - halved_bytes, std::uint8_t{2}, "halved");
    refuses(depth_code_bytes - visible_loss_bytes, std::uint8_t{2}, "visible loss");
}

TEST(FrameInfoPayload, OnlyDepthIsHalved) {
    FrameInfo colour = full_info();
    colour.depth_code.reset();
    auto payload = encode_frame_info(TrackRole::patches, colour);
    payload[payload.size() - halved_bytes] = 1;
    EXPECT_THROW(decode_frame_info(payload), WorkError);
}

TEST(FrameInfoPayload, QualityIsACrfOrNotSaid) {
    FrameInfo info = full_info();
    for (const std::optional<float> crf : {std::optional<float>(), {0.0f}, {51.0f}}) {
        info.crf = crf;
        const auto tagged = decode_frame_info(encode_frame_info(TrackRole::patches, info));
        ASSERT_TRUE(tagged);
        EXPECT_EQ(tagged->info.crf, crf);
    }
    for (const float crf : {-0.5f, -2.0f, std::nextafter(51.0f, 52.0f), std::numeric_limits<float>::infinity(),
                            std::numeric_limits<float>::quiet_NaN()}) {
        auto payload = full_payload();
        overwrite(payload, payload.size() - crf_bytes, crf);
        try {
            decode_frame_info(payload);
            ADD_FAILURE() << "accepted " << crf;
        } catch (const WorkError& error) {
            EXPECT_NE(std::string(error.what()).find("CRF of 0 to 51"), std::string::npos) << error.what();
        }
    }
}

TEST(FrameInfoPayload, AVersionToComeIsNamedAndIsNoDamage) {
    auto payload = full_payload();
    overwrite(payload, 16, std::uint16_t{7});
    try {
        decode_frame_info(payload);
        FAIL() << "read version 7";
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(),
                     "frame data in the stream: expected version 1, which this program reads, found version 7");
    }
}

TEST(FrameInfoPayload, FieldsOfLaterVersionsAreSkipped) {
    auto payload = full_payload();
    const auto size = static_cast<std::uint16_t>(payload.size() - header_bytes + 33);
    overwrite(payload, 18, size);
    payload.insert(payload.end(), 33, 0xee);
    const auto tagged = decode_frame_info(payload);
    ASSERT_TRUE(tagged);
    expect_same_info(tagged->info, full_info());
}

TEST(FrameInfoPayload, HostileValuesAreErrors) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto damaged_by = [](std::size_t offset, auto value) {
        auto payload = full_payload();
        overwrite(payload, offset, value);
        EXPECT_THROW(decode_frame_info(payload), WorkError) << offset;
    };
    damaged_by(18, std::uint16_t{0xffff});              // longer than what is there
    damaged_by(20, std::uint8_t{11});                   // role
    damaged_by(21, std::uint8_t{3});                    // camera kind
    damaged_by(22, std::uint8_t{3});                    // eye
    damaged_by(23, std::uint8_t{2});                    // lock
    damaged_by(24, std::uint32_t{max_image_side + 1});  // width
    damaged_by(24, std::uint32_t{0});
    damaged_by(28, std::uint32_t{0});                          // height
    damaged_by(28, std::uint32_t{0xffffffff});                 // height
    damaged_by(40, std::int64_t{-1});                          // index
    damaged_by(40, std::int64_t{1000000000});                  // the same
    damaged_by(48, nan);                                       // time
    damaged_by(48, -1.01e10);                                  // the same
    damaged_by(48, 1e300);                                     // the same
    damaged_by(56, 0.0);                                       // frames per second
    damaged_by(64, 3.5);                                       // longitude range backward
    damaged_by(64, 3.0 - 1e-9);                                // of almost nothing
    damaged_by(72, 1e19);                                      // longitude
    damaged_by(88, 1.6);                                       // beyond the pole
    damaged_by(96, nan);                                       // camera position
    damaged_by(96, 1e19);                                      // farther than single precision can square
    damaged_by(104, -1.01e9);                                  // the same
    damaged_by(120, 7.0);                                      // camera quaternion
    damaged_by(152, std::numeric_limits<double>::infinity());  // head position
    damaged_by(160, 1e19);                                     // the same
    damaged_by(208, 1e19);                                     // IPD
    damaged_by(208, -0.06);                                    // the same
    damaged_by(216, 1e4);                                      // head box
    damaged_by(224, -1.0);                                     // exposure
}

TEST(FrameInfoPayload, ACameraHasNoMorePixelsThanAPictureMay) {
    auto payload = full_payload();
    overwrite(payload, 24, std::uint32_t{max_image_side});
    overwrite(payload, 28, std::uint32_t{max_image_side});
    EXPECT_THROW(decode_frame_info(payload), WorkError);
}

TEST(FrameInfoPayload, PosesUpToTheLimitAreTaken) {
    FrameInfo info = full_info();
    info.camera_pose.position_m = info.head.position_m = {1e9, -1e9, 0};
    info.ipd_m = 10;
    info.head_radius_m = 1000;
    const auto tagged = decode_frame_info(encode_frame_info(TrackRole::patches, info));
    ASSERT_TRUE(tagged);
    expect_same_info(tagged->info, info);
}

TEST(FrameInfoPayload, OrientationsAreReadAtUnitLength) {
    FrameInfo info = full_info();
    info.camera_pose.orientation *= 0.9991;
    info.head.orientation *= 1.0009;
    const auto tagged = decode_frame_info(encode_frame_info(TrackRole::patches, info));
    ASSERT_TRUE(tagged);
    EXPECT_LT(glm::length(tagged->info.camera_pose.orientation - full_info().camera_pose.orientation), 1e-15);
    EXPECT_LT(glm::length(tagged->info.head.orientation - full_info().head.orientation), 1e-15);
}

TEST(FrameInfoPayload, RandomDamageNeverDoesMoreThanThrow) {
    std::mt19937 generator(11);
    for (int round = 0; round < 20000; ++round) {
        auto payload = full_payload();
        for (int i = 0; i < 3; ++i)
            payload[16 + generator() % (payload.size() - 16)] = static_cast<std::uint8_t>(generator());
        try {
            const auto tagged = decode_frame_info(payload);
            ASSERT_TRUE(tagged);
            EXPECT_LE(width_of(tagged->info.camera), max_image_side);
            EXPECT_TRUE(std::isfinite(tagged->info.camera_pose.position_m.x));
        } catch (const WorkError&) {
        } catch (const InputError&) {  // another version
        }
    }
}

TEST(FrameInfoPayload, NamesHaveALimit) {
    FrameInfo info;
    info.scene = std::string(256, 's');
    EXPECT_THROW(encode_frame_info(TrackRole::main, info), InputError);
}

}  // namespace
}  // namespace equistream
