// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace kestrel::flight {

// Who may watch. On loopback whoever is on this computer, elsewhere who knows the token. Neither a page of
// another site in a viewer's browser (Origin, RFC 6454) nor one whose name has been bound anew to this address
// (Host, against DNS rebinding) may.
class Access {
 public:
  // address: as it is listened at; origins: of other pages that may connect ("https://app.foxglove.dev").
  // token: empty: none is needed.
  Access(std::string address, std::string token, std::vector<std::string> origins);

  struct Request {
    std::string_view host;    // as the header has it, with its port
    std::string_view origin;  // empty: none, as of a program that is no browser
    std::string_view target;  // path?query
    bool foxglove =
        false;  // by its subprotocol, which only watches: a page that is a file, its application, may
  };
  // Why it is refused; empty: it is not.
  std::string Refusal(const Request& request) const;

 private:
  std::string address_, token_;
  std::vector<std::string> origins_;
};

bool IsLoopback(std::string_view address);  // of an address as digits
std::string RandomToken();                  // 128 bits of the operating system's, as digits of 16

}  // namespace kestrel::flight
