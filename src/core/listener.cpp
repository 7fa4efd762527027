#include "core/listener.h"

namespace sheen {
namespace {

thread_local const Listener* t_listener = nullptr;

}  // namespace

ListenerScope::ListenerScope(const Listener& listener) : before_(t_listener) {
    t_listener = &listener;
}
ListenerScope::~ListenerScope() { t_listener = before_; }

const Listener* currentListener() { return t_listener; }

}  // namespace sheen
