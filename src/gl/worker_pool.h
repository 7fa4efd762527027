// Threads that own one OpenGL context each. Drawing at the same time they keep in step: see
// DrawingPhases. Contexts share buffers and textures, while programs, vertex arrays and
// framebuffers belong to one worker. All OpenGL of the project runs inside run().
#pragma once

#include <barrier>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "gl/context.h"

namespace sheen::gl {

class WorkerPool {
  public:
    /// `workers` threads; one where the backend is a GPU, whose driver has its own parallelism.
    /// The software rasteriser shades with `shading_threads`, those of the first pool in a process.
    /// Environment error when no context can be made.
    WorkerPool(int workers, int shading_threads, Backend backend);
    explicit WorkerPool(int workers, Backend backend = kDefaultBackend)
        : WorkerPool(workers, workers, backend) {}
    ~WorkerPool();
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    int size() const { return static_cast<int>(threads_.size()); }
    const std::string& renderer() const { return renderer_; }

    /// Calls job(worker) once on every worker, at the same time, and waits; what they drew is
    /// finished then. The first exception (by worker) is rethrown.
    void run(const std::function<void(int worker)>& job);
    /// The same on worker 0 alone.
    void runOnFirst(const std::function<void()>& job);
    /// run() for destructors: frees what workers hold. Errors are let go: one that matters has been
    /// thrown before, and nothing is drawn any more.
    void release(const std::function<void(int worker)>& job) noexcept;

  private:
    void work(int worker);

    std::vector<std::unique_ptr<Context>> contexts_;
    std::vector<std::thread> threads_;
    std::vector<std::exception_ptr> errors_;
    std::string renderer_;
    std::mutex mutex_;
    std::condition_variable start_;
    std::condition_variable done_;
    const std::function<void(int)>* job_ = nullptr;
    int generation_ = 0;
    int running_ = 0;
    bool stopping_ = false;
};

/// Keeps workers that draw at the same time in step: all upload, then all draw, then all read back.
/// Mesa's rasteriser looks through the unfinished drawing of every context when one of them maps a
/// resource, without a lock: that crashes when another context is drawing just then.
class DrawingPhases {
  public:
    explicit DrawingPhases(int workers) : barrier_(workers) {}

    /// One worker's part in every round; must end in each worker, also by an exception.
    class Member {
      public:
        explicit Member(DrawingPhases& phases) : phases_(phases) {}
        ~Member() { phases_.barrier_.arrive_and_drop(); }
        Member(const Member&) = delete;
        Member& operator=(const Member&) = delete;

        /// Runs transfer() while no worker draws and no other one transfers.
        void transfer(const std::function<void()>& transfer) {
            const std::lock_guard<std::mutex> lock(phases_.mutex_);
            transfer();
        }
        /// Waits until every worker is ready, runs draw(), and waits until all have finished
        /// drawing.
        void draw(const std::function<void()>& draw);

      private:
        DrawingPhases& phases_;
    };

  private:
    std::barrier<> barrier_;
    std::mutex mutex_;
};

}  // namespace sheen::gl
