#include "core/failure.h"

#include <new>
#include <system_error>

namespace sheen {

Failure failureOf(const std::exception_ptr& exception) {
    try {
        std::rethrow_exception(exception);
    } catch (const Error& error) {
        return {error.code(), error.what()};
    } catch (const std::system_error& error) {  // of threads, and of printing
        return {ExitCode::kEnvironment, oneLine(error.what())};
    } catch (const std::bad_alloc&) {
        return {ExitCode::kEnvironment, "out of memory: try a smaller size"};
    } catch (const std::exception& error) {
        return {ExitCode::kBug, oneLine(error.what()) + "; this is a bug"};
    } catch (...) {
        return {ExitCode::kBug, "something unknown was thrown; this is a bug"};
    }
}

}  // namespace sheen
