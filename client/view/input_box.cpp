#include "input_box.h"

#include <chrono>
#include <utility>

namespace equistream {

void InputBox::put(const WindowInputs& inputs) {
    {
        const std::lock_guard lock(mutex_);
        inputs_.events.insert(inputs_.events.end(), inputs.events.begin(), inputs.events.end());
        inputs_.any = inputs_.any || inputs.any;
        inputs_.is_closed = inputs_.is_closed || inputs.is_closed;
        inputs_.window = inputs.window;
        inputs_.scale = inputs.scale;
    }
    came_.notify_one();
}

void InputBox::take(WindowInputs& inputs) {
    inputs.events.clear();
    const std::lock_guard lock(mutex_);
    std::swap(inputs.events, inputs_.events);
    inputs.any = std::exchange(inputs_.any, false);
    inputs.is_closed = inputs_.is_closed;
    inputs.window = inputs_.window;
    inputs.scale = inputs_.scale;
}

void InputBox::wait(double seconds) {
    std::unique_lock lock(mutex_);
    came_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return inputs_.any || inputs_.is_closed; });
}

void InputBox::wake() {
    {
        const std::lock_guard lock(mutex_);
        inputs_.any = true;
    }
    came_.notify_one();
}

void InputBox::ask_for_title(std::string title) {
    const std::lock_guard lock(mutex_);
    title_ = std::move(title);
}

std::optional<std::string> InputBox::take_title() {
    const std::lock_guard lock(mutex_);
    return std::exchange(title_, std::nullopt);
}

void InputBox::ask_to_keep(KeptSettings kept) {
    const std::lock_guard lock(mutex_);
    kept_ = std::move(kept);
}

std::optional<KeptSettings> InputBox::take_kept() {
    const std::lock_guard lock(mutex_);
    return std::exchange(kept_, std::nullopt);
}

}  // namespace equistream
