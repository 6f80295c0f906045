#include "figures.h"

#include <equistream/json_text.h>
#include <equistream/text.h>
#include <programs/cli/provenance.h>

#include <nlohmann/json.hpp>

namespace equistream::model {

namespace {

std::uintmax_t bytes_of(const std::filesystem::path& file) {
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(file, error);
    return error ? 0 : bytes;
}

nlohmann::ordered_json quantiles(const std::array<double, 4>& rad, double focal_px) {
    return {{"p50", rad[0] * focal_px},
            {"p99", rad[1] * focal_px},
            {"p99.9", rad[2] * focal_px},
            {"p99.99", rad[3] * focal_px}};
}

}  // namespace

std::string Figures::json() const {
    const RayCheck& c = of_model.check;
    nlohmann::ordered_json json = cli::provenance(request.command);
    json["scene"] = request.scene.string();
    json["model"] = request.out.string();
    json["error_px"] = request.error_px;
    json["share"] = request.share;
    json["focal_px"] = request.focal_px;
    json["seed"] = request.seed;
    json["box_radius_m"] = of_model.box_radius_m;
    json["triangles"] = {{"before", of_model.triangles_before},
                         {"seen", of_model.triangles_seen},
                         {"after", of_model.triangles_after},
                         {"unique_before", of_model.unique_before},
                         {"unique_after", of_model.unique_after}};
    json["bytes"] = bytes_of(std::filesystem::path(request.out).replace_extension(".glb"));
    json["seconds"] = {{"all", seconds},
                       {"visibility", of_model.visibility_s},
                       {"simplify", of_model.simplify_s},
                       {"check", of_model.check_s}};
    json["rounds"] = of_model.rounds;
    json["check"] = {{"rays", c.rays},
                     {"kept", c.kept()},
                     {"within", c.within},
                     {"at_edges", c.at_edges},
                     {"failing", c.failing},
                     {"displacement_px", quantiles(c.displacement_rad, request.focal_px)},
                     {"edge_shift_px", quantiles(c.edge_shift_rad, request.focal_px)}};
    return json_text(json, 2) + "\n";
}

std::string Figures::text() const {
    const RayCheck& c = of_model.check;
    const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
    const double f = request.focal_px;
    std::string out = formatted("%s: %llu of %llu triangles (%.1f %%), %.2f MB\n", request.out.string().c_str(),
                                number(of_model.triangles_after), number(of_model.triangles_before),
                                100 * double(of_model.triangles_after) / double(of_model.triangles_before),
                                1e-6 * double(bytes_of(std::filesystem::path(request.out).replace_extension(".glb"))));
    out += formatted("to be seen from the path: %llu\n", number(of_model.triangles_seen));
    out += formatted(
        "rays checked: %lld in the last of %d rounds; %.4f %% keep the bound of %g px, %.4f %% more at edges\n",
        static_cast<long long>(c.rays), of_model.rounds, 100 * double(c.within) / double(c.rays),
        request.error_px * request.share, 100 * double(c.at_edges) / double(c.rays));
    out += formatted("displacement, px: %.4f (median), %.4f (99 %%), %.4f (99.9 %%), %.4f (99.99 %%)\n",
                     f * c.displacement_rad[0], f * c.displacement_rad[1], f * c.displacement_rad[2],
                     f * c.displacement_rad[3]);
    out += formatted("shift of edges, px: at most %.3f (median of those rays), %.3f (99 %%)\n", f * c.edge_shift_rad[0],
                     f * c.edge_shift_rad[1]);
    out += formatted("seconds: %.1f (visibility %.1f, simplifying %.1f, checking %.1f)\n", seconds,
                     of_model.visibility_s, of_model.simplify_s, of_model.check_s);
    return out;
}

}  // namespace equistream::model
