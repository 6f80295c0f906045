#include "kept_settings.h"

#include <client/transport/address.h>
#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/sequence.h>
#include <equistream/stream.h>
#include <equistream/text.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>

namespace equistream {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t max_file_bytes = 1 << 16;

/// The setting of a name in the file: its own name, or its behind_name. Null: there is none.
const ShownSetting* kept_setting(std::string_view name) {
    const auto found = std::ranges::find_if(shown_settings(), [&](const ShownSetting& setting) {
        return setting.is_kept && (setting.name == name || (setting.behind && setting.behind_name == name));
    });
    return found == shown_settings().end() ? nullptr : &*found;
}

/// Reads one part of the file and says what is wrong with it.
class Reader {
public:
    explicit Reader(const json& all) : all_(all) {
        for (const auto& [name, value] : all_.items())
            if (name != "settings" && name != "window" && name != "recent")
                leave_out(name);
    }

    void read_values(std::map<std::string, std::string, std::less<>>& values) {
        const json settings = part("settings", json::value_t::object);
        for (const auto& [name, value] : settings.items()) {
            const ShownSetting* setting = kept_setting(name);
            ShownSettings tried;
            try {
                if (setting == nullptr || !value.is_string())
                    throw InputError(name);
                setting->set(tried, value.get<std::string>());
                values[name] = value.get<std::string>();
            } catch (const InputError&) {
                leave_out("settings." + name);
            }
        }
    }

    std::optional<DesktopPlace> read_window() {
        const json window = part("window", json::value_t::object);
        if (window.empty())
            return std::nullopt;
        const auto number = [&](const char* name, int least) {
            const auto found = window.find(name);
            if (found == window.end() || !found->is_number_integer())
                return std::optional<int>();
            const auto value = found->get<std::int64_t>();
            return value >= least && value <= KeptSettings::max_window_side ? std::optional(int(value)) : std::nullopt;
        };
        const auto left = number("left", -KeptSettings::max_window_side),
                   top = number("top", -KeptSettings::max_window_side), width = number("width", 1),
                   height = number("height", 1);
        if (left && top && width && height)
            return DesktopPlace{*left, *top, *width, *height};
        leave_out("window");
        return std::nullopt;
    }

    void read_recent(std::vector<std::string>& recent) {
        const json sources = part("recent", json::value_t::array);
        for (const json& source : sources) {
            const bool is_good =
                source.is_string() && source.get_ref<const std::string&>().size() <= KeptSettings::max_recent_bytes;
            if (is_good && recent.size() < KeptSettings::max_recent)
                recent.push_back(source.get<std::string>());
            else
                leave_out("recent");
        }
    }

    const std::string& left_out() const { return left_out_; }

private:
    json part(const char* name, json::value_t type) {
        const auto found = all_.find(name);
        if (found != all_.end() && found->type() == type)
            return *found;
        if (found != all_.end())
            leave_out(name);
        return json(type);
    }
    void leave_out(const std::string& name) {
        if (left_out_.find(name) == left_out_.npos)
            left_out_ += (left_out_.empty() ? "" : ", ") + as_json_holds(name, 64);
    }

    const json& all_;
    std::string left_out_;
};

}  // namespace

void KeptSettings::keep_changes(const ShownSettings& before, const ShownSettings& after) {
    for (const ShownSetting& setting : shown_settings()) {
        const bool is_other_behind = setting.behind && setting.behind(before) != setting.behind(after);
        if (!setting.is_kept || (setting.value(before) == setting.value(after) && !is_other_behind))
            continue;
        values[std::string(setting.name)] = setting.value(after);
        if (setting.behind && setting.behind(after) != setting.value(after))
            values[std::string(setting.behind_name)] = setting.behind(after);
    }
}

std::string KeptSettings::name_of(const std::string& source) {
    std::error_code error;
    const auto address = parse_server_address(source);
    const fs::path absolute = is_url(source) ? fs::path(source) : fs::absolute(source, error);
    return address ? address->text() : without_secrets(error ? source : absolute.string());
}

void KeptSettings::remember(const std::string& source) {
    const std::string name = name_of(source);
    if (!is_utf8(name) || name.size() > max_recent_bytes)
        return;
    insert(name);
}

void KeptSettings::insert(const std::string& name) {
    std::erase(recent, name);
    recent.insert(recent.begin(), name);
    if (recent.size() > max_recent)
        recent.resize(max_recent);
}

void KeptSettings::apply_to(ShownSettings& shown) const {
    for (const ShownSetting& setting : shown_settings())
        for (const std::string_view name : {setting.behind_name, setting.name})  // what is hidden, then what hides it
            if (const auto found = values.find(name); found != values.end())
                setting.set(shown, found->second);
}

fs::path kept_settings_file() {
    const auto folder = [](const char* variable) {
        const char* text = std::getenv(variable);
        return text == nullptr ? fs::path() : fs::path(text);
    };
    // What is not absolute counts as not set (XDG Base Directory Specification).
    fs::path config = folder("XDG_CONFIG_HOME");
    if (!config.is_absolute())
        config = folder("HOME").is_absolute() ? folder("HOME") / ".config" : fs::path();
    return config.empty() ? config : config / "equistream" / "view.json";
}

namespace {

/// Not an object where the file is damaged, cannot be read, or holds more than settings.
json json_in(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::string text(max_file_bytes + 1, '\0');
    stream.read(text.data(), std::streamsize(text.size()));
    text.resize(std::size_t(stream.gcount()));
    return !stream.is_open() || text.size() > max_file_bytes ? json() : json::parse(text, nullptr, false);
}

}  // namespace

ReadSettings read_kept_settings(const fs::path& file) {
    ReadSettings read;
    std::error_code error;
    if (!fs::exists(file, error) && !error)
        return read;
    const json all = json_in(file);
    if (!all.is_object()) {
        read.note = expected_found(file.string(), "settings of the viewer in JSON", "something else") +
                    "; the defaults are used, and the file is left as it is";
        read.may_be_written = false;
        return read;
    }
    Reader reader(all);
    reader.read_values(read.kept.values);
    read.kept.window = reader.read_window();
    reader.read_recent(read.kept.recent);
    if (!reader.left_out().empty())
        read.note = file.string() + ": ignored, as unknown or not possible: " + reader.left_out();
    return read;
}

void write_kept_settings(const fs::path& file, const KeptSettings& kept, const KeptSettings& was) {
    std::error_code error;
    json all = fs::exists(file, error) ? json_in(file) : json::object();
    if (!all.is_object())
        throw WorkError(expected_found(file.string(), "settings of the viewer in JSON", "something else"));
    if (!all["settings"].is_object())
        all["settings"] = json::object();
    for (const auto& [name, value] : kept.values)
        if (const auto before = was.values.find(name); before == was.values.end() || before->second != value)
            all["settings"][name] = value;
    if (kept.window && kept.window != was.window)
        all["window"] = {{"left", kept.window->left},
                         {"top", kept.window->top},
                         {"width", kept.window->width},
                         {"height", kept.window->height}};
    KeptSettings merged;
    Reader(all).read_recent(merged.recent);
    for (std::size_t i = kept.recent.size(); i-- > 0;) {
        const bool was_last = !was.recent.empty() && was.recent.front() == kept.recent[i];
        if (i == 0 ? !was_last : !std::ranges::count(was.recent, kept.recent[i]))
            merged.insert(kept.recent[i]);
    }
    all["recent"] = merged.recent;
    fs::create_directories(file.parent_path(), error);  // what is wrong with it, writing says
    write_file_atomically(file, json_text(all, 2) + "\n");
}

}  // namespace equistream
