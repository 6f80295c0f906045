/// Numbers that the page has from the C++ headers, as JSON: assemble.py puts them into it.
#include <client/gpu/shader_files.h>
#include <client/view/stereo_layout.h>
#include <client/warp/engine.h>
#include <equistream/yuv.h>

#include <nlohmann/json.hpp>

#include <cstdio>

namespace {

/// Column by column, as OpenGL takes it.
nlohmann::json as_json(const glm::mat3& matrix) {
    nlohmann::json numbers;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            numbers.push_back(matrix[column][row]);
    return numbers;
}

std::string colour_constants() {
    using namespace equistream::yuv_to_rgb;
    std::string text;
    for (const auto& [name, value] : {std::pair("SUM_BITS", sum_bits),
                                      {"LUMA_GAIN", luma_gain},
                                      {"OFFSET", offset},
                                      {"RED_FROM_CR", red_from_cr},
                                      {"GREEN_FROM_CB", green_from_cb},
                                      {"GREEN_FROM_CR", green_from_cr},
                                      {"BLUE_FROM_CB", blue_from_cb}})
        text += std::string("#define ") + name + " " + std::to_string(value) + "\n";
    return text;
}

}  // namespace

int main() {
    const equistream::EngineOptions engine;
    const equistream::Anaglyph& anaglyph = equistream::anaglyphs().front();
    const nlohmann::json numbers = {{"constants", equistream::gl::constants() + colour_constants()},
                                    {"budgetPx", engine.error_budget_px},
                                    {"meshBudgetPx", engine.source_depth_budget_px},
                                    {"meshShare", engine.mesh_share},
                                    {"fromLeft", as_json(anaglyph.from_left)},
                                    {"fromRight", as_json(anaglyph.from_right)}};
    std::printf("%s\n", numbers.dump().c_str());
    return 0;
}
