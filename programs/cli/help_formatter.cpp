#include "help_formatter.h"

#include "columns.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <string>

namespace equistream::cli {

namespace {

/// Options in one column, and what they mean in lines of a second one.
class Columns : public CLI::Formatter {
public:
    Columns() { column_width(std::min(std::size_t{34}, columns_ / 3 + 1)); }

    std::string make_option(const CLI::Option* option, bool is_positional) const override {
        return row(make_option_name(option, is_positional) + make_option_opts(option), make_option_desc(option));
    }
    std::string make_subcommand(const CLI::App* subcommand) const override {
        return row(subcommand->get_display_name(true), subcommand->get_description());
    }
    std::string make_description(const CLI::App* app) const override {
        return wrapped("", app->get_description(), columns_);
    }

private:
    std::string row(const std::string& name, const std::string& meaning) const {
        std::string head = "  " + name, above;
        if (head.size() + 2 > column_width_) {  // the least that stands between the columns
            above = head + "\n";
            head.clear();
        }
        head.resize(column_width_, ' ');
        return meaning.empty() && !above.empty() ? above : above + wrapped(head, meaning, columns_);
    }

    std::size_t columns_ = output_columns();
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> help_formatter() {
    return std::make_shared<Columns>();
}

}  // namespace equistream::cli
