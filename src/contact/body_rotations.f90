! SPDX-License-Identifier: BSD-3-Clause
!> Rotations of the bodies with a free rigid motion, and deformations of all bodies. If rotations or deformations are large, the
!> equations of small displacements are wrong.
module sig_body_rotations
  use sig_contact_state, only: contact_state_t
  use sig_cross_products, only: cross_product
  use sig_kinds, only: rk
  use sig_linear_algebra, only: solve_dense
  use sig_reasons, only: reason_converged
  use sig_rigid_motions, only: rigid_motions_t
  implicit none(type, external)
  private
  public :: largest_deformation, largest_rotation

contains

  !> [rad] Returns the largest angle by which a body with a free motion rotates in any of the states that converged; 0 without such
  !> bodies or states, and in axisymmetry.
  real(rk) function largest_rotation(motions, states) result(angle)
    type(rigid_motions_t), intent(in) :: motions
    type(contact_state_t), intent(in) :: states(:)
    integer :: i, k

    angle = 0
    if (motions%is_round) return
    do k = 1, size(states)
      if (states(k)%reason /= reason_converged) cycle
      associate (vectors => reshape(states(k)%displacement, shape(motions%coordinates)))
        do i = 1, motions%n_bodies
          if (any(motions%body_of_motion == i)) angle = max(angle, rotation_of(motions, i, vectors))
        end do
      end associate
    end do
  end function largest_rotation

  !> [-] Returns the largest displacement of a node relative to the mean displacement of its body, divided by the largest distance
  !> of a node of the body from its center, over all bodies and all states that converged; 0 without such states. Except in
  !> axisymmetry, it is the strain of a body that is stretched alike in all directions, and at most the angle of a body that
  !> rotates. In axisymmetry the mean along the radius counts as 0.
  pure real(rk) function largest_deformation(motions, states) result(largest)
    type(rigid_motions_t), intent(in) :: motions
    type(contact_state_t), intent(in) :: states(:)
    real(rk) :: means(size(motions%coordinates, 1), motions%n_bodies)
    integer :: i, k, n_nodes(motions%n_bodies)

    largest = 0
    do k = 1, size(states)
      if (states(k)%reason /= reason_converged) cycle
      associate (vectors => reshape(states(k)%displacement, shape(motions%coordinates)), body => motions%body_of_node)
        means = 0
        n_nodes = 0
        do i = 1, size(body)
          means(:, body(i)) = means(:, body(i)) + vectors(:, i)
          n_nodes(body(i)) = n_nodes(body(i)) + 1
        end do
        means = means / spread(n_nodes, 1, size(means, 1))
        if (motions%is_round) means(1, :) = 0
        do i = 1, size(body)
          largest = max(largest, norm2(vectors(:, i) - means(:, body(i))) / motions%sizes(body(i)))
        end do
      end associate
    end do
  end function largest_deformation

  !> [rad] Returns the angle of the rigid rotation that fits the displacements of a body best: with x from its center, w solves
  !> sum(|x|^2 - x x') w = sum(x cross u) over its nodes. 0 for a body whose nodes lie on a line.
  real(rk) function rotation_of(motions, i_body, vectors) result(angle)
    type(rigid_motions_t), intent(in) :: motions
    !> 1-based
    integer, intent(in) :: i_body
    !> [length] displacements of the nodes, shape (n_dim, n_nodes)
    real(rk), intent(in) :: vectors(:, :)
    real(rk) :: inertia(3, 3), moment(3), rotation(3), u(3), x(3)
    integer :: i
    logical :: is_singular

    inertia = 0
    moment = 0
    do i = 1, size(vectors, 2)
      if (motions%body_of_node(i) /= i_body) cycle
      x = 0
      u = 0
      x(:size(vectors, 1)) = (motions%coordinates(:, i) - motions%centers(:, i_body)) / motions%sizes(i_body)
      u(:size(vectors, 1)) = vectors(:, i) / motions%sizes(i_body)
      inertia = inertia - spread(x, 2, 3) * spread(x, 1, 3)
      inertia(1, 1) = inertia(1, 1) + dot_product(x, x)
      inertia(2, 2) = inertia(2, 2) + dot_product(x, x)
      inertia(3, 3) = inertia(3, 3) + dot_product(x, x)
      moment = moment + cross_product(x, u)
    end do
    call solve_dense(inertia, moment, rotation, is_singular)
    angle = 0
    if (.not. is_singular) angle = norm2(rotation)
  end function rotation_of
end module sig_body_rotations
