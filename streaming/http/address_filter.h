// Which addresses a server may send us to: those of the public Internet. The rest (this machine,
// its neighbours, a cloud's metadata service) may be asked only when the user names the host.
#pragma once

#include <string>
#include <vector>

struct sockaddr;

namespace gnomon {

// After IANA's special-purpose registries; v4 addresses inside v6 ones are judged as what they are.
bool isPublicAddress(const sockaddr& address);

// True for a host that is itself an address of this machine or a private network, in any way of
// writing it, or a name that always means this machine: to be refused before anybody, such as a
// proxy, is asked for it. False for all other names, which are judged once resolved.
bool isPrivateHost(const std::string& host);

// Addresses with ports ("10.0.0.1 3128") of the proxies that the environment names: connections to
// these are the user's own wish.
std::vector<std::string> proxyEndpoints();
std::string endpointOf(const sockaddr& address);

} // namespace gnomon
