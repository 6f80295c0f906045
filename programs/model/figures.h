#pragma once
/// What `equistream model` was asked for and what it found, as a table and as JSON.
#include <client/model/client_model.h>
#include <equistream/bound.h>

#include <filesystem>
#include <string>

namespace equistream::model {

/// A model as coarse as this was as good as all geometry in five scenes (docs/decisions/0016).
inline constexpr double default_model_error_px = 4;

struct Request {
    std::string command;
    std::filesystem::path scene, out;
    double error_px = default_model_error_px;
    double focal_px = default_focal_length_px;
    double share = default_budget_share;
    double ipd_m = default_ipd_m;
    std::int64_t visibility_rays = ClientModelOptions{}.visibility_rays;
    std::int64_t check_rays = ClientModelOptions{}.check_rays;
    double quantile = ClientModelOptions{}.kept_quantile;
    int rounds = ClientModelOptions{}.rounds;
    std::uint64_t seed = 1;
};

struct Figures {
    Request request;
    ClientModelFigures of_model;
    double seconds = 0;  ///< loading and writing included

    std::string text() const;
    std::string json() const;
};

}  // namespace equistream::model
