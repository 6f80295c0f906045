/// Messages from viewers: what is a pose comes out, everything else is passed over.
#include <equistream/viewer_message.h>

#include <gtest/gtest.h>

#include <malloc.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

namespace equistream {
namespace {

using Bytes = std::vector<std::uint8_t>;

ViewerPose some_pose(double x) {
    return {1.25, {{x, 2, -3e8}, glm::dquat(0.5, -0.5, 0.5, 0.5)}};
}

template <typename T>
void put(Bytes& bytes, std::size_t offset, T value) {
    std::memcpy(bytes.data() + offset, &value, sizeof value);
}

void append(Bytes& bytes, const Bytes& more) {
    bytes.insert(bytes.end(), more.begin(), more.end());
}

void expect_pose(const std::optional<ViewerPose>& found, const ViewerPose& expected) {
    ASSERT_TRUE(found);
    EXPECT_EQ(found->time_s, expected.time_s);
    EXPECT_EQ(found->head.position_m, expected.head.position_m);
    EXPECT_EQ(found->head.orientation, expected.head.orientation);
}

TEST(ViewerMessage, LiesInMemoryAsTheTableSays) {
    const Bytes bytes = encode_viewer_pose(some_pose(7));
    ASSERT_EQ(bytes.size(), 76u);
    const Bytes header = {'E', 'Q', 'V', 'M', 1, 0, 1, 0, 64, 0, 0, 0};
    EXPECT_TRUE(std::equal(header.begin(), header.end(), bytes.begin()));
    const double fields[] = {1.25, 7, 2, -3e8, 0.5, -0.5, 0.5, 0.5};
    EXPECT_EQ(std::memcmp(bytes.data() + 12, fields, sizeof fields), 0);
}

TEST(ViewerMessage, ComesOutOfPiecesOfAnySize) {
    Bytes bytes;
    for (int i = 0; i < 5; ++i)
        append(bytes, encode_viewer_pose(some_pose(i)));
    for (const std::size_t piece : {1u, 2u, 7u, 76u, 77u, 1000u}) {
        ViewerMessageReader reader;
        std::optional<ViewerPose> last;
        for (std::size_t at = 0; at < bytes.size(); at += piece)
            if (const auto pose = reader.take(std::span(bytes).subspan(at, std::min(piece, bytes.size() - at))))
                last = pose;
        expect_pose(last, some_pose(4));
    }
}

TEST(ViewerMessage, NoNumberThatIsNonePasses) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    struct Change {
        std::size_t field;
        double value;
    };
    for (const Change& change :
         {Change{0, nan}, {1, nan}, {2, inf}, {3, -2e9}, {3, 1e9}, {4, nan}, {4, 0.6}, {5, 0.5001}}) {
        Bytes bytes = encode_viewer_pose(some_pose(1));
        put(bytes, 12 + 8 * change.field, change.value);
        ViewerMessageReader reader;
        EXPECT_FALSE(reader.take(bytes)) << change.field << " " << change.value;
        expect_pose(reader.take(encode_viewer_pose(some_pose(2))), some_pose(2));
    }
}

TEST(ViewerMessage, OtherKindsAndVersionsArePassedOverWhole) {
    for (const std::size_t offset : {4u, 6u}) {
        Bytes other = encode_viewer_pose(some_pose(1));
        put(other, offset, std::uint16_t(2));
        put(other, 8, std::uint32_t(200));
        Bytes inside(136, 0);
        const Bytes pose = encode_viewer_pose(some_pose(3));  // is no message of its own
        std::copy(pose.begin(), pose.end(), inside.begin());
        append(other, inside);
        ViewerMessageReader reader;
        EXPECT_FALSE(reader.take(other));
        expect_pose(reader.take(encode_viewer_pose(some_pose(2))), some_pose(2));
    }
}

TEST(ViewerMessage, FieldsThatAreAppendedAreSkippedAndShortOnesRefused) {
    Bytes longer = encode_viewer_pose(some_pose(1));
    put(longer, 8, std::uint32_t(72));
    append(longer, Bytes(8, 0xff));
    append(longer, encode_viewer_pose(some_pose(2)));
    expect_pose(ViewerMessageReader().take(longer), some_pose(2));
    Bytes shorter = encode_viewer_pose(some_pose(1));
    put(shorter, 8, std::uint32_t(56));
    EXPECT_FALSE(ViewerMessageReader().take(shorter));
}

TEST(ViewerMessage, SaysWhatIsShownWhereTheViewerDoes) {
    ViewerPose pose = some_pose(1);
    EXPECT_FALSE(ViewerMessageReader().take(encode_viewer_pose(pose))->view) << "as viewers before did";
    pose.view = {1.25, 0.75};
    const Bytes bytes = encode_viewer_pose(pose);
    ASSERT_EQ(bytes.size(), 92u);
    for (const std::size_t piece : {1u, 13u, 92u}) {
        ViewerMessageReader reader;
        std::optional<ViewerPose> found;
        for (std::size_t at = 0; at < bytes.size(); at += piece)
            found = reader.take(std::span(bytes).subspan(at, std::min(piece, bytes.size() - at)));
        expect_pose(found, pose);
        ASSERT_TRUE(found->view);
        EXPECT_EQ(found->view->half_width, 1.25);
        EXPECT_EQ(found->view->half_height, 0.75);
    }
    Bytes one = bytes;  // and only half of what is shown
    put(one, 8, std::uint32_t(72));
    one.resize(84);
    const auto found = ViewerMessageReader().take(one);
    expect_pose(found, pose);
    EXPECT_FALSE(found->view);
}

TEST(ViewerMessage, AViewThatIsNoneIsNotSaid) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    for (const double half : {nan, inf, -inf, 0.0, -1.0, 1e-3, 58.0, 1e300, 5e-324})
        for (const bool of_height : {false, true}) {
            ViewerPose pose = some_pose(1);
            pose.view = {of_height ? 1 : half, of_height ? half : 1};
            const auto found = ViewerMessageReader().take(encode_viewer_pose(pose));
            expect_pose(found, pose);
            EXPECT_FALSE(found->view) << half;
        }
    for (const double half : {0.01, 57.0}) {
        ViewerPose pose = some_pose(1);
        pose.view = {half, half};
        EXPECT_TRUE(ViewerMessageReader().take(encode_viewer_pose(pose))->view) << half;
    }
}

TEST(ViewerMessage, SaysWhetherTheHeadOnlyLooks) {
    for (const bool shows : {false, true}) {
        ViewerPose pose = some_pose(4);
        pose.steers = false;
        if (shows)
            pose.view = ViewExtent{1, 0.75};
        const Bytes bytes = encode_viewer_pose(pose);
        EXPECT_EQ(bytes.size(), 100u);
        const auto taken = ViewerMessageReader().take(bytes);
        expect_pose(taken, pose);
        ASSERT_TRUE(taken);
        EXPECT_FALSE(taken->steers);
        EXPECT_EQ(taken->view.has_value(), shows);
    }
    EXPECT_TRUE(ViewerMessageReader().take(encode_viewer_pose(some_pose(4))).value().steers);
}

TEST(ViewerMessage, GarbageIsNotKept) {
    const auto held = [] {
        const auto info = mallinfo2();
        return info.uordblks + info.hblkhd;
    };
    ViewerMessageReader reader;
    const Bytes garbage(4096, 'E');  // of a message's beginning
    const std::size_t before = held();
    for (int i = 0; i < 4096; ++i)
        EXPECT_FALSE(reader.take(garbage));
    EXPECT_LT(held(), before + (1 << 20)) << "of 16 MiB";
    expect_pose(reader.take(encode_viewer_pose(some_pose(2))), some_pose(2));
}

TEST(ViewerMessage, GarbageAndLengthsBeyondAllBoundsAreSearchedForTheNextOne) {
    std::mt19937 random(7);
    ViewerMessageReader reader;
    for (int round = 0; round < 200; ++round) {
        Bytes bytes(random() % 3000);
        for (std::uint8_t& byte : bytes)
            byte = std::uint8_t(random());
        append(bytes, {'E', 'Q', 'V', 'M', 1, 0, 1, 0, 0xff, 0xff, 0xff, 0xff});
        append(bytes, {'E', 'Q', 'V'});
        append(bytes, encode_viewer_pose(some_pose(round)));
        expect_pose(reader.take(bytes), some_pose(round));
    }
}

}  // namespace
}  // namespace equistream
