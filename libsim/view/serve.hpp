#pragma once
#include <filesystem>
#include <functional>
#include <string>

/// A run's picture over HTTP, for folders that are too large for one page and for runs in progress.
namespace subsoil::sim {

struct ServeRequest {
  std::filesystem::path run;
  int port = 0;     ///< 0: one that is free
  double idle = 0;  ///< s without a request after which it ends, unless a run is active; 0: never
};

/// Answers requests until the process ends or `idle` is over. Listens on the loopback interface only. Answers GET
/// alone, and below a path that holds 128 random bits; whoever does not know it gets 404. Requests whose Host is
/// another name are refused, so that pages of other sites cannot ask through a name of their own that resolves to this
/// machine.
/// @param ready takes the address of the page before the first request
void serve_run(const ServeRequest& request, const std::function<void(const std::string&)>& ready);

}  // namespace subsoil::sim
