! SPDX-License-Identifier: BSD-3-Clause
!> Cross products of two vectors: a vector in space, a number in the plane.
module sig_cross_products
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: cross_product, plane_cross_product

contains

  !> Returns a x b in space.
  pure function cross_product(a, b) result(product)
    real(rk), intent(in) :: a(3)
    real(rk), intent(in) :: b(3)
    real(rk) :: product(3)

    product = [a(2) * b(3) - a(3) * b(2), a(3) * b(1) - a(1) * b(3), a(1) * b(2) - a(2) * b(1)]
  end function cross_product

  !> Returns the component of a x b across the plane, a(1) b(2) - a(2) b(1): positive where b lies to the left of a.
  pure real(rk) function plane_cross_product(a, b) result(product)
    real(rk), intent(in) :: a(2)
    real(rk), intent(in) :: b(2)

    product = a(1) * b(2) - a(2) * b(1)
  end function plane_cross_product
end module sig_cross_products
