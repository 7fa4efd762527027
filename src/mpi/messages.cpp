#include "mpi/messages.h"

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <thread>

#include "core/bytes.h"
#include "core/error.h"

namespace sheen {
namespace {

std::string pack(const std::vector<std::string>& texts) {
    ByteWriter out;
    for (const std::string& text : texts) {
        out.put(text);
    }
    return out.bytes();
}

std::vector<std::string> unpack(const std::string& bytes) {
    std::vector<std::string> texts;
    for (ByteReader in(bytes); !in.atEnd();) {
        texts.push_back(in.get<std::string>());
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
