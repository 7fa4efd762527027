// What ranks tell each other: texts, by kind. No one polls while there is nothing to hear.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace sheen {

/// MPI's tags. Hello and failed must stay as they are: ranks of other versions say them, too.
enum class MessageKind : int {
    kHello = 1,   ///< to the first rank: who one is, on which host
    kReady = 2,   ///< to the first rank: the job that units are wanted of
    kDone = 3,    ///< to the first rank: the answer to a unit, and what was warned of
    kFailed = 4,  ///< to the first rank: the exit code and why; no unit is wanted any more
    kUnit = 5,    ///< what to do; then, where it is news, what that depends on
    kLeave = 6,   ///< there is nothing more to do
};

struct Message {
    int from = 0;
    MessageKind kind = MessageKind::kHello;
    std::vector<std::string> texts;
};

void send(int to, MessageKind kind, const std::vector<std::string>& texts);

/// One that has come, of that kind or of any, if there is one.
std::optional<Message> receive(std::optional<MessageKind> kind = {});

/// The next to come. Sleeps until then.
Message await(std::optional<MessageKind> kind = {});

/// Sleeps between looks for what is awaited, the longer the more often it was not there, at most
/// 5 ms: MPI's own waiting takes all of a processor.
class Patience {
  public:
    void wait();
    void reset() { microseconds_ = kLeast; }

  private:
    static constexpr int kLeast = 50, kMost = 5000;
    int microseconds_ = kLeast;
};

}  // namespace sheen
