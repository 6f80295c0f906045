/// OpenCV's remap as a peer: bilinear, RGBA, its fixed-point map made beforehand, as only an eye that never moves
/// could.
#include "eye_stages.h"

#include <benchmark/benchmark.h>

#include <opencv2/imgproc.hpp>

namespace {

using namespace equistream;

/// One 1920x1080 view of a 3840x1920 sphere.
class Remap {
public:
    Remap() : picture_(bench::big_picture(4)) {
        cv::Mat u(bench::big_view.height, bench::big_view.width, CV_32FC1), v(u.size(), CV_32FC1);
        for (int y = 0; y < u.rows; ++y)
            for (int x = 0; x < u.cols; ++x) {
                const glm::dvec2 p = bench::big_sphere.pixel(bench::big_view.direction(x + 0.5, y + 0.5));
                u.at<float>(y, x) = float(p.x - 0.5);
                v.at<float>(y, x) = float(p.y - 0.5);
            }
        cv::convertMaps(u, v, cells_, fractions_, CV_16SC2);
    }
    void run() {
        const cv::Mat sphere(picture_.height(), picture_.width(), CV_8UC4, picture_.pixel(0, 0));
        cv::remap(sphere, view_, cells_, fractions_, cv::INTER_LINEAR);
        benchmark::DoNotOptimize(view_.data);
    }

private:
    ByteImage picture_;
    cv::Mat cells_, fractions_, view_;
};

void remap(benchmark::State& state, int eyes) {
    Remap views[2];
    for (auto _ : state)
        for (int i = 0; i < eyes; ++i)
            views[i].run();
}

void add(const char* figure, int eyes) {
    benchmark::RegisterBenchmark((std::string(figure) + "/opencv_remap").c_str(), remap, eyes)
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
}

[[maybe_unused]] const bool added = [] {
    for (const char* figure : {"rotate_1080p", "rotate_rgb_1080p", "rotate_yuv_1080p"})
        add(figure, 1);
    for (const char* figure : {"two_eyes_1080p_pavilion", "two_eyes_1080p_sponza-crytek"})
        add(figure, 2);
    return true;
}();

}  // namespace
