/// Decoders write into memory that is handed to them, and the pictures are what they are anywhere else.
#include "synthetic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <mutex>
#include <new>
#include <set>
#include <utility>

namespace equistream {
namespace {

/// Blocks between guards that nobody may write over, no more at once than there is room for.
class Blocks : public PictureMemory {
public:
    explicit Blocks(std::size_t room) : room_(room) {}

    std::shared_ptr<std::uint8_t> take(std::size_t bytes) override {
        const std::lock_guard lock(mutex_);
        if (held_.size() == room_)
            return nullptr;
        auto* const whole = static_cast<std::uint8_t*>(::operator new(bytes + 2 * guard, std::align_val_t(guard)));
        std::fill_n(whole, bytes + 2 * guard, mark);
        const std::pair block(whole + guard, bytes);
        held_.insert(block);
        ++taken_;
        return {block.first, [this, block](std::uint8_t*) { release(block); }};
    }

    bool holds(const std::uint8_t* sample) const {
        const std::lock_guard lock(mutex_);
        return std::ranges::any_of(
            held_, [&](const auto& block) { return sample >= block.first && sample < block.first + block.second; });
    }
    std::size_t held() const {
        const std::lock_guard lock(mutex_);
        return held_.size();
    }
    int taken() const { return taken_; }

private:
    static constexpr std::size_t guard = 64;
    static constexpr std::uint8_t mark = 0xa7;
    using Block = std::pair<std::uint8_t*, std::size_t>;

    void release(const Block& block) {
        const std::lock_guard lock(mutex_);
        EXPECT_TRUE(std::all_of(block.first - guard, block.first, [](auto byte) { return byte == mark; }));
        EXPECT_TRUE(std::all_of(block.first + block.second, block.first + block.second + guard,
                                [](auto byte) { return byte == mark; }));
        held_.erase(block);
        ::operator delete(block.first - guard, std::align_val_t(guard));
    }

    std::size_t room_;
    mutable std::mutex mutex_;
    std::set<Block> held_;
    int taken_ = 0;
};

template <typename T>
void expect_same(const Yuv420View<T>& a, const Yuv420View<T>& b) {
    for (const auto plane : {&Yuv420View<T>::y, &Yuv420View<T>::cb, &Yuv420View<T>::cr}) {
        ASSERT_EQ((a.*plane).width, (b.*plane).width);
        ASSERT_EQ((a.*plane).height, (b.*plane).height);
        for (int y = 0; y < (a.*plane).height; ++y)
            ASSERT_TRUE(std::equal((a.*plane).row(y), (a.*plane).row(y) + (a.*plane).width, (b.*plane).row(y)));
    }
}

/// Pictures that lie in the blocks.
int expect_same_pictures(const std::filesystem::path& file, const std::shared_ptr<Blocks>& blocks) {
    StreamReader ordinary(file.string(), {.yuv = true, .pq = true});
    StreamReader handed(file.string(), {.yuv = true, .pq = true, .memory = blocks});
    int inside = 0;
    std::vector<DecodedPicture> kept;  // what is held is not written over
    std::vector<DecodedPicture> expected;
    while (auto picture = ordinary.next()) {
        auto found = handed.next();
        EXPECT_TRUE(found);
        if (!found)
            break;
        expected.push_back(std::move(*picture));
        kept.push_back(std::move(*found));
    }
    EXPECT_FALSE(handed.next());
    for (std::size_t i = 0; i < kept.size(); ++i) {
        EXPECT_FALSE(kept[i].yuv.empty() && kept[i].pq.empty());
        if (!kept[i].yuv.empty()) {
            expect_same(expected[i].yuv.planes, kept[i].yuv.planes);
            inside += blocks->holds(kept[i].yuv.planes.y.data) && blocks->holds(kept[i].yuv.planes.cr.data);
        } else {
            expect_same(expected[i].pq.planes, kept[i].pq.planes);
            inside += blocks->holds(reinterpret_cast<const std::uint8_t*>(kept[i].pq.planes.y.data));
        }
    }
    return inside;
}

TEST(PictureMemory, PicturesAreTheSame) {
    const synthetic::Folder folder;
    for (const Codec codec : {Codec::h264, Codec::h265}) {
        synthetic::Made made = synthetic::small_stream(codec, true);
        made.settings.tracks[0].width = 200;  // of whole blocks the last are cut
        made.settings.tracks[0].height = 100;
        synthetic::write(folder / "a.mkv", made);
        const auto blocks = std::make_shared<Blocks>(1000);
        EXPECT_EQ(expect_same_pictures(folder / "a.mkv", blocks), 2 * made.pictures);
        EXPECT_EQ(blocks->held(), 0u) << "all is given back";
    }
}

TEST(PictureMemory, WhatThereIsNoRoomForLiesElsewhere) {
    const synthetic::Folder folder;
    const synthetic::Made made = synthetic::small_stream(Codec::h264, false);
    synthetic::write(folder / "a.mkv", made);
    const auto few = std::make_shared<Blocks>(5), none = std::make_shared<Blocks>(0);
    const int inside = expect_same_pictures(folder / "a.mkv", few);
    EXPECT_GT(inside, 0);
    EXPECT_LT(inside, made.pictures);
    EXPECT_EQ(expect_same_pictures(folder / "a.mkv", none), 0);
}

TEST(PictureMemory, OfTenBitsToo) {
    const synthetic::Folder folder;
    StreamSettings settings;
    settings.codec = Codec::h265;
    settings.transfer = Transfer::pq;
    settings.preset = "veryfast";
    settings.tracks = {{TrackRole::main, 192, 96}};
    StreamWriter writer((folder / "a.mkv").string(), settings);
    for (int index = 0; index < 8; ++index) {
        FloatImage pq(192, 96, 3);
        for (std::size_t i = 0; i < pq.samples().size(); ++i)
            pq.samples()[i] = float((i * 7 + std::size_t(index) * 100) % 997) / 997;
        writer.write_pq(TrackRole::main, pq.view(), synthetic::info(192, 96, index));
    }
    writer.finish();
    EXPECT_EQ(expect_same_pictures(folder / "a.mkv", std::make_shared<Blocks>(1000)), 8);
}

/// Video of two sizes, one after the other.
TEST(PictureMemory, ASizeMayChangeInTheMiddle) {
    const synthetic::Folder folder;
    std::ofstream both(folder / "both.h264", std::ios::binary);
    synthetic::Made made = synthetic::small_stream(Codec::h264, false);
    made.settings.tagged = false;
    made.settings.sphere.reset();
    for (const auto& [width, height] : {std::pair{192, 96}, {328, 164}}) {
        made.settings.tracks = {{TrackRole::main, width, height}};
        synthetic::write(folder / "one.h264", made);
        both << std::ifstream(folder / "one.h264", std::ios::binary).rdbuf();
        std::filesystem::remove(folder / "one.h264");
    }
    both.close();
    const auto blocks = std::make_shared<Blocks>(1000);
    EXPECT_EQ(expect_same_pictures(folder / "both.h264", blocks), 2 * made.pictures);
    EXPECT_EQ(blocks->held(), 0u);
}

}  // namespace
}  // namespace equistream
