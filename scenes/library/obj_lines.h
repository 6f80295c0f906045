#pragma once
/// Lines of an OBJ or MTL file as its statements are written: continued lines joined, ends of any system, tabs, blanks
/// and comments out of the way, and each with the number that errors name.
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

namespace equistream {

struct ObjLine {
    int number = 0;       ///< of the first line it was written on
    std::string keyword;  ///< "f"
    std::string rest;     ///< what follows, without blanks at either end

    /// The first word of `rest` from `at` on, which moves past it; empty at the end.
    std::string_view next_word(std::size_t& at) const;
};

class ObjLines {
public:
    /// Throws InputError if the file cannot be opened as `what` ("model", "material file") or is too large.
    ObjLines(const std::filesystem::path& file, const std::string& what);

    /// The next statement; nothing at the end. A line of more than 1 MiB or one with a zero byte throws.
    std::optional<ObjLine> next();
    /// "FILE:LINE", for errors.
    std::string where(int line) const { return file_ + ":" + std::to_string(line); }

private:
    bool read_physical(std::string& line);

    std::string file_;
    std::ifstream stream_;
    int read_ = 0;
};

/// A word as a plain decimal number; nothing for one that is not, or not finite.
std::optional<double> obj_number(std::string_view word);

}  // namespace equistream
