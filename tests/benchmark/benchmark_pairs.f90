! SPDX-License-Identifier: BSD-3-Clause
!> Times the pairing of two spherical surfaces along their averaged normals, in CPU time, for surfaces of growing size.
!>
!> Argument: how many sizes (4 unless it is given).
program benchmark_pairs
  use sig_deck_config, only: averaged_tolerance, contact_config_t
  use sig_errors, only: error_report, error_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_node_pairs, only: find_node_pairs, node_pairs_t
  use shell_meshes, only: shell_mesh
  implicit none(type, external)
  type(mesh_t) :: mesh
  type(node_pairs_t) :: pairs
  type(contact_config_t) :: contact
  type(error_t), allocatable :: error
  real(rk) :: start, finish
  character(16) :: argument
  integer :: i, n, n_sizes

  contact%first%text = 'inner'
  contact%second%text = 'outer'
  contact%pairing_tolerance = averaged_tolerance
  n_sizes = 4
  call get_command_argument(1, argument)
  if (argument /= '') read (argument, *) n_sizes
  do i = 0, n_sizes - 1
    n = 50 * 2**i
    call shell_mesh(3, n, [0.9_rk, 1.0_rk, 1.0001_rk, 1.1_rk], mesh)
    call cpu_time(start)
    call find_node_pairs(mesh, .false., [contact], 'benchmark', pairs, error)
    call cpu_time(finish)
    if (allocated(error)) error stop error_report(error)
    print '(i7, a, f7.3, a, f7.3, a)', pairs%n_pairs, ' pairs: ', finish - start, ' s, ', &
      1.0e6_rk * (finish - start) / pairs%n_pairs, ' us per pair'
  end do
end program benchmark_pairs
