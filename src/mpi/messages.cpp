#include "mpi/messages.h"

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <thread>

#include "core/error.h"

namespace sheen {
namespace {

// Each text after its size.
std::string pack(const std::vector<std::string>& texts) {
    std::string bytes;
    for (const std::string& text : texts) {
        const uint64_t size = text.size();
        bytes.append(reinterpret_cast<const char*>(&size), sizeof(size));
        bytes += text;
    }
    return bytes;
}

std::vector<std::string> unpack(const std::string& bytes) {
    std::vector<std::string> texts;
    for (size_t at = 0; at < bytes.size();) {
        uint64_t size = 0;
        SHEEN_CHECK(bytes.size() - at >= sizeof(size));
        std::memcpy(&size, bytes.data() + at, sizeof(size));
        at += sizeof(size);
        SHEEN_CHECK(bytes.size() - at >= size);
        texts.push_back(bytes.substr(at, size));
        at += size;
    }
    return texts;
}

}  // namespace

void send(int to, MessageKind kind, const std::vector<std::string>& texts) {
    const std::string bytes = pack(texts);
    SHEEN_CHECK(bytes.size() <= INT32_MAX);
    MPI_Send(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, to, static_cast<int>(kind),
             MPI_COMM_WORLD);
}

std::optional<Message> receive(std::optional<MessageKind> kind) {
    const int tag = kind ? static_cast<int>(*kind) : MPI_ANY_TAG;
    int is_there = 0, size = 0;
    MPI_Status status;
    MPI_Iprobe(MPI_ANY_SOURCE, tag, MPI_COMM_WORLD, &is_there, &status);
    if (is_there == 0) {
        return std::nullopt;
    }
    MPI_Get_count(&status, MPI_BYTE, &size);
    std::string bytes(static_cast<size_t>(size), '\0');
    MPI_Recv(bytes.data(), size, MPI_BYTE, status.MPI_SOURCE, status.MPI_TAG, MPI_COMM_WORLD,
             MPI_STATUS_IGNORE);
    return Message{status.MPI_SOURCE, static_cast<MessageKind>(status.MPI_TAG), unpack(bytes)};
}

Message await(std::optional<MessageKind> kind) {
    Patience patience;
    while (true) {
        if (std::optional<Message> message = receive(kind)) {
            return std::move(*message);
        }
        patience.wait();
    }
}

void Patience::wait() {
    std::this_thread::sleep_for(std::chrono::microseconds(microseconds_));
    microseconds_ = std::min(2 * microseconds_, kMost);
}

}  // namespace sheen
