#pragma once
/// `equistream scene describe`: a scene description for a model that has none.
#include <programs/cli/command_line.h>

#include <filesystem>
#include <optional>
#include <string>

namespace equistream {

struct DescribeArguments {
    std::string command;
    std::filesystem::path model, out;  ///< out: empty for a description beside the model
    std::optional<double> unit_m;
    bool overwrite = false, json = false;
};

cli::CommandLine add_describe_command(cli::CommandLine& app, DescribeArguments& arguments);

/// Writes the description and says on standard output what was guessed for it.
void describe(const DescribeArguments& arguments);

}  // namespace equistream
