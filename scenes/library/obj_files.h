#pragma once
/// Which other files an OBJ names, found although their names are not quite right: backslashes, another case, a folder
/// of the machine they were made on.
#include <glm/glm.hpp>

#include <filesystem>
#include <fstream>
#include <functional>
#include <istream>
#include <optional>
#include <streambuf>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace equistream {

bool is_obj(const std::filesystem::path& model);

/// The file that `name` means, relative to `folder`: as written, with slashes for backslashes, in any case of ASCII
/// letters, in UTF-8 if it is written in Latin-1, and last by its name alone. Nothing if there is none.
std::optional<std::filesystem::path> find_named_file(const std::filesystem::path& folder, const std::string& name);

/// Files that an `mtllib` statement names: names may hold blanks, so all of it is tried before its words are.
/// Those that are not there are left out.
std::vector<std::filesystem::path> find_material_files(const std::filesystem::path& folder, const std::string& names);

/// A texture statement: "-s 2 2 1 wood.tga".
struct ObjTexture {
    std::string name;               ///< as written; empty if there is none
    glm::vec2 scale{1}, offset{0};  ///< of texture coordinates, -s and -o
    bool clamp = false;
    bool is_beyond = false;  ///< a number of -s or -o is too large for a float, and left out
};

ObjTexture parse_texture(const std::string& statement);

/// The MTL files that an OBJ names and the images that those name, as far as they are there.
std::vector<std::filesystem::path> files_of_obj(const std::filesystem::path& model);

// Lines of an OBJ or MTL file as its statements are written: continued lines joined, ends of any system, tabs, blanks
// and comments out of the way, and each with the number that errors name.

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
    void join_continued(std::string& text, std::size_t begin);

    std::string file_;
    std::ifstream stream_;
    int read_ = 0;
};

/// A word as a plain decimal number; nothing for one that is not, or not finite.
std::optional<double> obj_number(std::string_view word);

// Feeds tinyobjloader one statement at a time, so that its callbacks run while the line they stem from is the last one
// that was handed over.

/// Gives a statement without its line end, or nothing at the end of the file; may throw.
using NextStatement = std::function<std::optional<std::string>()>;

class StatementBuffer : public std::streambuf {
public:
    explicit StatementBuffer(NextStatement next) : next_(std::move(next)) {}

private:
    int_type underflow() override {
        std::optional<std::string> statement = next_();
        if (!statement)
            return traits_type::eof();
        text_ = std::move(*statement) + "\n";
        setg(text_.data(), text_.data(), text_.data() + text_.size());
        return traits_type::to_int_type(text_.front());
    }

    NextStatement next_;
    std::string text_;
};

class StatementStream : public std::istream {
public:
    explicit StatementStream(NextStatement next) : std::istream(nullptr), buffer_(std::move(next)) {
        rdbuf(&buffer_);
        exceptions(std::ios::badbit);  // hands on what the buffer throws
    }

private:
    StatementBuffer buffer_;
};

}  // namespace equistream
