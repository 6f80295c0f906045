#pragma once
/// What a reader of OBJ and MTL made do with: one line for each kind of trouble, however often it is met.
#include <map>
#include <string>
#include <vector>

namespace equistream {

class ObjNotes {
public:
    /// `where` is "FILE:LINE"; notes of the same text are told once, with the place of the first.
    void add(const std::string& where, const std::string& text);
    /// In the order in which they came up.
    std::vector<std::string> lines() const;

private:
    struct Note {
        std::string where, text;
        int more = 0;
    };
    std::vector<Note> notes_;
    std::map<std::string, std::size_t> index_of_text_;
};

}  // namespace equistream
