#pragma once
/// What an object's traverse() shows: values by name and the objects below it. One level.
#include <mitsuba/core/object.h>
#include <mitsuba/mitsuba.h>

#include <map>
#include <stdexcept>
#include <string>
#include <typeinfo>
#include <vector>

namespace equistream::mitsuba_host {

class Parameters : public mitsuba::TraversalCallback {
public:
    explicit Parameters(mitsuba::Object& object) : name_(object.id()) { object.traverse(this); }

    bool has(const std::string& name) const { return values_.count(name) > 0; }
    /// Null where there is none, or one of another type.
    template <typename T>
    T* find(const std::string& name) const {
        const auto found = values_.find(name);
        return found != values_.end() && *found->second.type == typeid(T) ? static_cast<T*>(found->second.value)
                                                                          : nullptr;
    }
    template <typename T>
    T& get(const std::string& name) const {
        if (T* value = find<T>(name))
            return *value;
        throw std::runtime_error("\"" + name_ + "\": expected a parameter \"" + name + "\" of type " +
                                 typeid(T).name());
    }
    /// Null where there is none.
    mitsuba::Object* object(const std::string& name) const {
        for (const auto& [key, object] : objects_)
            if (key == name)
                return object;
        return nullptr;
    }
    /// In the object's own order.
    const std::vector<std::pair<std::string, mitsuba::Object*>>& objects() const { return objects_; }

protected:
    void put_value(std::string_view name, void* value, std::uint32_t, const std::type_info& type) override {
        values_[std::string(name)] = {value, &type};
    }
    void put_object(std::string_view name, mitsuba::Object* object, std::uint32_t) override {
        objects_.emplace_back(name, object);
    }

private:
    struct Value {
        void* value = nullptr;
        const std::type_info* type = nullptr;
    };
    std::string name_;
    std::map<std::string, Value> values_;
    std::vector<std::pair<std::string, mitsuba::Object*>> objects_;
};

}  // namespace equistream::mitsuba_host
