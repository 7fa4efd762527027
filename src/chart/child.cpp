#include "chart/child.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <sstream>

#include "core/error.h"
#include "core/timer.h"

namespace sheen {
namespace {

const char* const kErrorPrefix = "sheen: error: ";
const char* const kWarningPrefix = "sheen: warning: ";
constexpr int kCannotRun = 127;  // what a shell returns as well

class Pipe {
  public:
    Pipe() {
        if (pipe2(ends_.data(), O_CLOEXEC) != 0) {
            throwEnvironment("cannot make a pipe: {}", std::strerror(errno));
        }
    }
    ~Pipe() {
        closeEnd(0);
        closeEnd(1);
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;

    int readEnd() const { return ends_[0]; }
    int writeEnd() const { return ends_[1]; }
    void closeEnd(size_t end) {
        if (ends_[end] >= 0) {
            close(ends_[end]);
            ends_[end] = -1;
        }
    }

  private:
    std::array<int, 2> ends_{-1, -1};
};

std::vector<char*> pointers(const std::vector<std::string>& texts) {
    std::vector<char*> list;
    for (const std::string& text : texts) {
        list.push_back(const_cast<char*>(text.c_str()));  // exec's signature predates const
    }
    list.push_back(nullptr);
    return list;
}

// This process's variables, `added` in place of those of the same name. Those by which mpirun makes
// a process a rank are left out: a child is none.
std::vector<std::string> environmentWith(const std::vector<std::string>& added) {
    std::vector<std::string> all = added;
    for (char** variable = environ; *variable != nullptr; ++variable) {
        const std::string text = *variable;
        const std::string name = text.substr(0, text.find('=') + 1);
        bool replaced = name.starts_with("OMPI_") || name.starts_with("PMIX_");
        for (const std::string& other : added) {
            replaced = replaced || other.rfind(name, 0) == 0;
        }
        if (!replaced) {
            all.push_back(text);
        }
    }
    return all;
}

// Reads both pipes until the child has closed them; in turns, since a full pipe would block it.
void readBoth(Pipe& first, std::string& first_text, Pipe& second, std::string& second_text) {
    std::array<pollfd, 2> polled = {{{first.readEnd(), POLLIN, 0}, {second.readEnd(), POLLIN, 0}}};
    const std::array<std::string*, 2> texts = {&first_text, &second_text};
    std::array<char, 65536> buffer{};
    while (polled[0].fd >= 0 || polled[1].fd >= 0) {
        if (poll(polled.data(), polled.size(), -1) < 0 && errno != EINTR) {
            throwEnvironment("cannot wait for a render: {}", std::strerror(errno));
        }
        for (size_t i = 0; i < polled.size(); ++i) {
            if (polled[i].fd < 0 || polled[i].revents == 0) {
                continue;
            }
            const ssize_t got = read(polled[i].fd, buffer.data(), buffer.size());
            if (got > 0) {
                texts[i]->append(buffer.data(), static_cast<size_t>(got));
            } else if (got == 0 || errno != EINTR) {
                polled[i].fd = -1;
            }
        }
    }
}

std::vector<std::string> warningsIn(const std::string& err) {
    std::vector<std::string> warnings;
    std::istringstream lines(err);
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with(kWarningPrefix)) {
            warnings.push_back(line.substr(std::strlen(kWarningPrefix)));
        }
    }
    return warnings;
}

[[noreturn]] void rethrow(int code, const std::string& program, const std::string& err) {
    const size_t at = err.rfind(kErrorPrefix);
    if (at == std::string::npos) {
        throwEnvironment("{}: cannot be run, or ended with exit code {}", program, code);
    }
    const std::string line = err.substr(at + std::strlen(kErrorPrefix));
    const bool documented = code >= 1 && code <= static_cast<int>(ExitCode::kEnvironment);
    throw Error(documented ? static_cast<ExitCode>(code) : ExitCode::kEnvironment,
                line.substr(0, line.find('\n')));
}

}  // namespace

ChildRun runChild(const std::vector<std::string>& command,
                  const std::vector<std::string>& variables) {
    // All memory the child needs is taken before the fork: other threads may hold the heap's lock.
    const std::vector<std::string> environment = environmentWith(variables);
    const std::vector<char*> arguments = pointers(command);
    const std::vector<char*> environment_pointers = pointers(environment);
    Pipe out, err;
    ChildRun run;
    const Timer timer;
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child < 0) {
        throwEnvironment("{}: cannot be run: {}", command[0], std::strerror(errno));
    }
    if (child == 0) {
        prctl(PR_SET_PDEATHSIG, SIGTERM);
        if (getppid() != parent) {
            _exit(kCannotRun);  // the parent ended before the line above
        }
        dup2(out.writeEnd(), STDOUT_FILENO);
        dup2(err.writeEnd(), STDERR_FILENO);
        execve(arguments[0], arguments.data(), environment_pointers.data());
        _exit(kCannotRun);
    }
    out.closeEnd(1);
    err.closeEnd(1);
    std::string err_text;
    readBoth(out, run.out, err, err_text);
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    run.seconds = timer.seconds();
    if (WIFSIGNALED(status)) {
        throwEnvironment("{}: ended by signal {} ({}); out of memory?", command[0],
                         WTERMSIG(status), strsignal(WTERMSIG(status)));
    }
    if (WEXITSTATUS(status) != 0) {
        rethrow(WEXITSTATUS(status), command[0], err_text);
    }
    run.warnings = warningsIn(err_text);
    return run;
}

}  // namespace sheen
