// Who hears of progress and warnings instead of standard error: whoever calls Sheen as a library.
#pragma once

#include <functional>
#include <string>

namespace sheen {

/// Empty functions hear nothing.
struct Listener {
    /// What is under way and the share of it that is done, [0, 1]; from any thread, one at a time.
    /// An exception of it ends the work and passes through it.
    std::function<void(const std::string& label, double done)> progress;
    std::function<void(const std::string& message)> warning;
};

/// While it lives, `listener` is told what this thread warns of and how far work is that it begins,
/// and nothing of that is printed.
class ListenerScope {
  public:
    explicit ListenerScope(const Listener& listener);
    ~ListenerScope();
    ListenerScope(const ListenerScope&) = delete;
    ListenerScope& operator=(const ListenerScope&) = delete;

  private:
    const Listener* before_;
};

/// This thread's; null: what it says is printed.
const Listener* currentListener();

}  // namespace sheen
