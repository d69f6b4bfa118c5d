// Whether this program is built with a sanitizer that reserves terabytes of address space, so that
// the address space of a process cannot be limited.
#pragma once

namespace cdb::library {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kReservesAddresses = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
inline constexpr bool kReservesAddresses = true;
#else
inline constexpr bool kReservesAddresses = false;
#endif
#else
inline constexpr bool kReservesAddresses = false;
#endif

}  // namespace cdb::library
