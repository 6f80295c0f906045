#include <plugin/depth_code/row_kernels.h>

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cstring>
#include <limits>
#include <random>
#include <vector>

namespace equistream::depth_rows {
namespace {

constexpr std::size_t odd = 203;    // no multiple of any vector
constexpr std::size_t wide = 4500;  // more than is kept of a row at a time

/// One set of rows under each instruction set that this machine has.
class EveryInstructionSet : public testing::Test {
protected:
    template <typename Check>
    void for_each(const Check& check) {
        const Rows plain = plain_rows();
        int tried = 0;
        for (std::int64_t bit = 1; bit > 0 && bit <= HWY_SCALAR; bit <<= 1) {
            hwy::SetSupportedTargetsForTest(0);
            if ((hwy::SupportedTargets() & bit) == 0)
                continue;
            hwy::SetSupportedTargetsForTest(bit);
            SCOPED_TRACE(hwy::TargetName(bit));
            const Rows simd = simd_rows();
            for (const std::size_t size : {std::size_t(1), std::size_t(64), odd, wide})
                for (const bool has_empty : {false, true})
                    check(simd, plain, DepthRange{0.0315, 0.4, has_empty}, size);
            ++tried;
        }
        hwy::SetSupportedTargetsForTest(0);
        EXPECT_GT(tried, 0);
    }

    std::vector<float> some_depths(std::size_t size) {
        std::uniform_real_distribution<float> logarithm(-3, 5);
        std::vector<float> depth_m(size);
        for (float& r : depth_m) {
            const auto kind = generator() % 16;
            r = kind == 0   ? std::numeric_limits<float>::infinity()
                : kind == 1 ? std::numeric_limits<float>::quiet_NaN()
                : kind == 2 ? 0.0f
                            : std::exp(logarithm(generator));
        }
        return depth_m;
    }
    template <typename T>
    std::vector<T> some_samples(std::size_t size) {
        std::vector<T> samples(size);
        for (T& sample : samples)
            sample = T(generator());
        return samples;
    }
    static void expect_same_bits(const std::vector<float>& a, const std::vector<float>& b) {
        for (std::size_t i = 0; i < a.size(); ++i)
            ASSERT_TRUE((std::isnan(a[i]) && std::isnan(b[i])) || std::memcmp(&a[i], &b[i], sizeof(float)) == 0)
                << i << ": " << a[i] << " and " << b[i];
    }

    std::mt19937 generator{17};
};

template <typename T>
struct ThreePlanes {
    explicit ThreePlanes(std::size_t size) : planes{std::vector<T>(size), std::vector<T>(size), std::vector<T>(size)} {}
    std::vector<T> planes[3];
    T* const data[3] = {planes[0].data(), planes[1].data(), planes[2].data()};

    bool operator==(const ThreePlanes& other) const {
        return planes[0] == other.planes[0] && planes[1] == other.planes[1] && planes[2] == other.planes[2];
    }
};

TEST_F(EveryInstructionSet, PacksAsPlainRowsDo) {
    for_each([&](const Rows& simd, const Rows& plain, const DepthRange& range, std::size_t size) {
        for (int round = 0; round < 20; ++round) {
            const std::vector<float> depth_m = some_depths(size);
            std::vector<std::uint8_t> bytes(size), plain_bytes(size);
            EXPECT_EQ(simd.pack_w8(depth_m, Scale(range, 255), bytes.data()),
                      plain.pack_w8(depth_m, Scale(range, 255), plain_bytes.data()));
            EXPECT_EQ(bytes, plain_bytes);
            std::vector<std::uint16_t> words(size), plain_words(size);
            EXPECT_EQ(simd.pack_w16(depth_m, Scale(range, 4095), words.data()),
                      plain.pack_w16(depth_m, Scale(range, 4095), plain_words.data()));
            EXPECT_EQ(words, plain_words);

            ThreePlanes<std::uint8_t> three(size), plain_three(size);
            EXPECT_EQ(simd.pack_pece(depth_m, Scale(range, pece_full), three.data),
                      plain.pack_pece(depth_m, Scale(range, pece_full), plain_three.data));
            EXPECT_EQ(three, plain_three);
            EXPECT_EQ(simd.pack_hue(depth_m, Scale(range, hue_full), three.data),
                      plain.pack_hue(depth_m, Scale(range, hue_full), plain_three.data));
            EXPECT_EQ(three, plain_three);
            const std::size_t even = size + size % 2;
            const std::vector<float> upper_m = some_depths(even), lower_m = some_depths(even);
            ThreePlanes<std::uint8_t> pair(even), plain_pair(even);
            std::vector<std::uint8_t> second(even), plain_second(even);
            const auto halves = [&](ThreePlanes<std::uint8_t>& to, std::vector<std::uint8_t>& wave) {
                return PecePair{upper_m, lower_m, {to.data[0], to.data[1]}, {to.data[2], wave.data()}};
            };
            EXPECT_EQ(simd.pack_pece420(halves(pair, second), Scale(range, pece_full)),
                      plain.pack_pece420(halves(plain_pair, plain_second), Scale(range, pece_full)));
            EXPECT_EQ(pair, plain_pair);
            EXPECT_EQ(second, plain_second);
            ThreePlanes<std::uint16_t> bits(size), plain_bits(size);
            simd.pack_bits(depth_m, bits.data);
            plain.pack_bits(depth_m, plain_bits.data);
            EXPECT_EQ(bits, plain_bits);
        }
    });
}

TEST_F(EveryInstructionSet, UnpacksAsPlainRowsDo) {
    for_each([&](const Rows& simd, const Rows& plain, const DepthRange& range, std::size_t size) {
        for (int round = 0; round < 20; ++round) {
            std::vector<float> depth_m(size), plain_m(size);
            const auto bytes = some_samples<std::uint8_t>(size);
            simd.unpack_w8(bytes.data(), Scale(range, 255), depth_m);
            plain.unpack_w8(bytes.data(), Scale(range, 255), plain_m);
            expect_same_bits(depth_m, plain_m);
            const auto words = some_samples<std::uint16_t>(size);
            simd.unpack_w16(words.data(), Scale(range, 4095), depth_m);
            plain.unpack_w16(words.data(), Scale(range, 4095), plain_m);
            expect_same_bits(depth_m, plain_m);

            const auto more = some_samples<std::uint8_t>(size), most = some_samples<std::uint8_t>(size);
            const std::uint8_t* const planes[3] = {bytes.data(), more.data(), most.data()};
            simd.unpack_pece(planes, Scale(range, pece_full), depth_m);
            plain.unpack_pece(planes, Scale(range, pece_full), plain_m);
            expect_same_bits(depth_m, plain_m);
            simd.unpack_pece420(bytes.data(), more.data(), Scale(range, pece_full), depth_m);
            plain.unpack_pece420(bytes.data(), more.data(), Scale(range, pece_full), plain_m);
            expect_same_bits(depth_m, plain_m);
            simd.unpack_hue(planes, Scale(range, hue_full), depth_m);
            plain.unpack_hue(planes, Scale(range, hue_full), plain_m);
            expect_same_bits(depth_m, plain_m);
            const auto high = some_samples<std::uint16_t>(size), low = some_samples<std::uint16_t>(size);
            const std::uint16_t* const bits[3] = {words.data(), high.data(), low.data()};
            simd.unpack_bits(bits, depth_m);
            plain.unpack_bits(bits, plain_m);
            expect_same_bits(depth_m, plain_m);
        }
    });
}

}  // namespace
}  // namespace equistream::depth_rows
