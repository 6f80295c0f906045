#include "mtl_file.h"

#include "obj_files.h"

#include <equistream/error.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

namespace equistream {

namespace {

/// What follows a statement's keyword.
enum class Operand { text, numbers, texture, ignored };

struct Statement {
    const char* spelling;  // tinyobjloader's
    Operand operand;
};

constexpr Statement statements[] = {
    {"newmtl", Operand::text},       {"Ka", Operand::ignored},       {"Kd", Operand::numbers},
    {"Ks", Operand::numbers},        {"Ke", Operand::numbers},       {"Tf", Operand::numbers},
    {"Ni", Operand::numbers},        {"Ns", Operand::numbers},       {"illum", Operand::numbers},
    {"d", Operand::numbers},         {"Tr", Operand::numbers},       {"Pr", Operand::numbers},
    {"Pm", Operand::numbers},        {"map_Ka", Operand::texture},   {"map_Kd", Operand::texture},
    {"map_d", Operand::texture},     {"map_Ke", Operand::texture},   {"map_Ks", Operand::ignored},
    {"map_Ns", Operand::ignored},    {"map_Ni", Operand::ignored},   {"map_bump", Operand::ignored},
    {"bump", Operand::ignored},      {"map_norm", Operand::ignored}, {"norm", Operand::ignored},
    {"map_disp", Operand::ignored},  {"disp", Operand::ignored},     {"decal", Operand::ignored},
    {"refl", Operand::ignored},      {"map_refl", Operand::ignored}, {"map_Pr", Operand::ignored},
    {"map_Pm", Operand::ignored},    {"map_Ps", Operand::ignored},   {"Refl", Operand::ignored},
    {"sharpness", Operand::ignored}, {"map_aat", Operand::ignored},  {"Km", Operand::ignored}};

bool same_word(const std::string& a, const char* b) {
    const auto same = [](char x, char y) {
        return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
    };
    const std::string other = b;
    return a.size() == other.size() && std::equal(a.begin(), a.end(), other.begin(), same);
}

class MtlReader {
public:
    MtlReader(const std::filesystem::path& file, ObjNotes& notes)
        : file_(file.string()), lines_(file, "material file (MTL)"), notes_(notes) {}

    std::vector<MtlMaterial> read() {
        StatementStream stream([this] { return next(); });
        std::map<std::string, int> index_of_name;
        std::vector<tinyobj::material_t> values;
        std::string warning, error;
        tinyobj::LoadMtl(&index_of_name, &values, &stream, &warning, &error);
        for (std::size_t i = 0; i < materials_.size(); ++i)
            materials_[i].values = values.at(i);
        return std::move(materials_);
    }

private:
    /// The next statement that tinyobjloader is to see.
    std::optional<std::string> next() {
        while (auto line = lines_.next()) {
            const auto found = std::find_if(std::begin(statements), std::end(statements),
                                            [&](const Statement& s) { return same_word(line->keyword, s.spelling); });
            if (found == std::end(statements))
                skip(*line, "an unknown statement, " + line->keyword);
            else if (found->operand == Operand::text)
                begin_material(*line);
            else if (materials_.empty())
                skip(*line, "a statement before newmtl");
            else if (found->operand == Operand::ignored)
                ignore(*line, found->spelling);
            else if (found->operand == Operand::texture)
                take_texture(*line, *found);
            else
                take(*line, *found);
            if (!statement_.empty())
                return std::exchange(statement_, {});
        }
        return std::nullopt;
    }

    void skip(const ObjLine& line, const std::string& what) {
        notes_.add(lines_.where(line.number), what + ": not used");
    }

    /// Ka says nothing that a path tracer wants; of what a picture would show there is a note.
    void ignore(const ObjLine& line, const std::string& spelling) {
        if (spelling != "Ka")
            notes_.add(lines_.where(line.number), spelling + " is not used");
    }

    void begin_material(const ObjLine& line) {
        if (line.rest.empty())
            return skip(line, "newmtl without a name");
        if (materials_.size() >= material_limit)
            throw InputError(expected_found(lines_.where(line.number), "at most 2^16 materials", "more"));
        materials_.emplace_back();
        materials_.back().file = file_;
        materials_.back().line = line.number;
        statement_ = "newmtl " + line.rest;
    }

    void take_texture(const ObjLine& line, const Statement& statement) {
        ObjTexture texture = parse_texture(line.rest);
        if (texture.name.empty())
            return skip(line, line.keyword + " without a file");
        if (texture.is_beyond)
            notes_.add(lines_.where(line.number), "a number of " + line.keyword + " is too large: left out");
        materials_.back().line_of[statement.spelling] = line.number;
        materials_.back().textures[statement.spelling] = std::move(texture);
    }

    /// Hands a statement of numbers over and keeps its line, unless they are none.
    void take(const ObjLine& line, const Statement& statement) {
        const std::string operand = numbers(line);
        if (operand.empty()) {
            notes_.add(lines_.where(line.number),
                       "expected numbers after " + line.keyword + ", found \"" + line.rest + "\": not used");
            return;
        }
        if (std::string(statement.spelling) == "Tr")
            materials_.back().tr = static_cast<float>(*obj_number(operand));
        materials_.back().line_of[statement.spelling] = line.number;
        statement_ = statement.spelling + (" " + operand);
    }

    /// The numbers after a keyword as tinyobjloader wants them (one colour for three); empty if they are none.
    static std::string numbers(const ObjLine& line) {
        std::vector<std::string> words;
        for (std::size_t at = 0; at < line.rest.size();) {
            const std::string word(line.next_word(at));
            if (word.empty() || word.front() == '#')
                break;
            if (word == "-halo")
                continue;
            const auto number = obj_number(word);
            if (!number || !std::isfinite(static_cast<float>(*number)))
                return {};
            words.push_back(word.front() == '+' ? word.substr(1) : word);
        }
        if (words.empty() ||
            (line.keyword.front() != 'K' && line.keyword.front() != 'k' && !same_word(line.keyword, "Tf")))
            return words.empty() ? std::string() : words[0];
        words.resize(3, words[0]);
        return words[0] + " " + words[1] + " " + words[2];
    }

    std::string file_;
    ObjLines lines_;
    ObjNotes& notes_;
    std::vector<MtlMaterial> materials_;
    std::string statement_;  ///< to be handed over
};

}  // namespace

std::vector<MtlMaterial> read_mtl(const std::filesystem::path& file, ObjNotes& notes) {
    return MtlReader(file, notes).read();
}

void ObjNotes::add(const std::string& where, const std::string& text) {
    const auto [entry, added] = index_of_text_.try_emplace(text, notes_.size());
    if (added)
        notes_.push_back({where, text});
    else
        ++notes_[entry->second].more;
}

std::vector<std::string> ObjNotes::lines() const {
    std::vector<std::string> lines;
    for (const Note& note : notes_)
        lines.push_back(quotable(note.where, 4096) + ": " + quotable(note.text, 400) +
                        (note.more > 0 ? " (and " + std::to_string(note.more) + " more)" : ""));
    return lines;
}

}  // namespace equistream
