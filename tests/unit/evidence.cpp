#include "evidence.h"

#include <equistream/picture.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

namespace equistream::test {

namespace {

namespace fs = std::filesystem;

/// "Suite.Test.2": one number for each call of a test.
std::string next_name() {
    static std::map<std::string, int> calls;
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    std::string name = test == nullptr ? "outside" : std::string(test->test_suite_name()) + "." + test->name();
    std::ranges::replace(name, '/', '.');
    return name + "." + std::to_string(++calls[name]);
}

float max_finite(const FloatImage& image) {
    float largest = 0;
    for (const float value : image.samples())
        if (std::isfinite(value))
            largest = std::max(largest, std::abs(value));
    return largest;
}

FloatImage scaled(ImageView<const float> image, float factor) {
    FloatImage out(image.width, image.height, image.channels);
    for (int y = 0; y < image.height; ++y)
        std::transform(image.row(y), image.row(y) + image.width * image.channels, out.pixel(0, y),
                       [=](float value) { return std::isfinite(value) ? value * factor : value; });
    return out;
}

FloatImage absolute_difference(const FloatImage& a, const FloatImage& b) {
    FloatImage out(a.width(), a.height(), a.channels());
    std::ranges::transform(a.samples(), b.samples(), out.samples().begin(), [](float x, float y) {
        return x == y ? 0 : std::isfinite(x) && std::isfinite(y) ? std::abs(x - y) : HUGE_VALF;
    });
    return out;
}

void write(const fs::path& file, const FloatImage& image) {
    write_picture(file, quantise_8bit(image.view()).view());
}

}  // namespace

std::string evidence(ImageView<const float> image, ImageView<const float> reference) {
    if (image.width != reference.width || image.height != reference.height || image.channels != reference.channels)
        return "\nimage and reference differ in shape";
    const fs::path folder = fs::current_path() / "failed-pictures";
    const std::string name = next_name();
    const auto place = [&](const char* what) { return folder / (name + "." + what + ".png"); };
    try {
        fs::create_directories(folder);
        const float brightest = std::max(1.0f, max_finite(scaled(reference, 1)));
        const FloatImage a = scaled(image, 1 / brightest), b = scaled(reference, 1 / brightest);
        const FloatImage difference = absolute_difference(a, b);
        const float worst = max_finite(difference);
        const float gain = worst > 0 ? 1 / worst : 1;
        write(place("image"), a);
        write(place("reference"), b);
        write(place("difference"), scaled(difference.view(), gain));
        return "\nimage, reference and difference (times " + std::to_string(gain / brightest) + ") are in " +
               place("*").string();
    } catch (const std::exception& error) {
        return std::string("\nno pictures: ") + error.what();
    }
}

std::string evidence(ImageView<const std::uint8_t> image, ImageView<const std::uint8_t> reference) {
    return evidence(widen_8bit(image).view(), widen_8bit(reference).view());
}

}  // namespace equistream::test
