#include "gl/worker_pool.h"

#include <algorithm>

#include "core/error.h"
#include "gl/functions.h"

namespace sheen::gl {

WorkerPool::WorkerPool(int workers, int shading_threads, Backend backend) {
    SHEEN_CHECK(workers > 0 && shading_threads > 0);
    if (backend == Backend::kEgl) {
        workers = 1;
    }
    for (int i = 0; i < workers; ++i) {
        contexts_.push_back(
            makeContext(backend, i > 0 ? contexts_[0].get() : nullptr, shading_threads));
        if (i == 0) {
            renderer_ = rendererName();
        }
        contexts_.back()->release();
    }
    errors_.resize(static_cast<size_t>(workers));
    for (int i = 0; i < workers; ++i) {
        threads_.emplace_back([this, i] { work(i); });
    }
}

WorkerPool::~WorkerPool() {
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        stopping_ = true;
    }
    start_.notify_all();
    for (std::thread& thread : threads_) {
        thread.join();
    }
}

void WorkerPool::work(int worker) {
    std::exception_ptr without_context;
    try {
        contexts_[static_cast<size_t>(worker)]->makeCurrent();
    } catch (...) {
        without_context = std::current_exception();  // told by the first run()
    }
    int seen = 0;
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
        start_.wait(lock, [&] { return stopping_ || generation_ != seen; });
        if (stopping_) {
            break;
        }
        seen = generation_;
        const std::function<void(int)>* job = job_;
        lock.unlock();
        try {
            if (without_context) {
                std::rethrow_exception(without_context);
            }
            (*job)(worker);
            glFinish();
            checkErrors();
        } catch (...) {
            errors_[static_cast<size_t>(worker)] = std::current_exception();
        }
        lock.lock();
        if (--running_ == 0) {
            done_.notify_all();
        }
    }
    lock.unlock();
    contexts_[static_cast<size_t>(worker)]->release();
}

void WorkerPool::run(const std::function<void(int)>& job) {
    std::unique_lock<std::mutex> lock(mutex_);
    SHEEN_CHECK_EQ(running_, 0);
    job_ = &job;
    running_ = size();
    std::fill(errors_.begin(), errors_.end(), nullptr);
    ++generation_;
    start_.notify_all();
    done_.wait(lock, [&] { return running_ == 0; });
    for (const std::exception_ptr& error : errors_) {
        if (error) {
            std::rethrow_exception(error);
        }
    }
}

void WorkerPool::runOnFirst(const std::function<void()>& job) {
    run([&](int worker) {
        if (worker == 0) {
            job();
        }
    });
}

void WorkerPool::release(const std::function<void(int)>& job) noexcept {
    try {
        run(job);
    } catch (...) {
    }
}

void DrawingPhases::Member::draw(const std::function<void()>& draw) {
    phases_.barrier_.arrive_and_wait();
    draw();
    glFinish();
    phases_.barrier_.arrive_and_wait();
}

}  // namespace sheen::gl
